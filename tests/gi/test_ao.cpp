// Ambient occlusion against closed forms: of half balls (SSAO) and of directions (horizons), from images made in double.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "core/camera.h"
#include "core/error.h"
#include "core/host_math.h"
#include "gi/screen/screen.h"
#include "raster/light_view.h"

using namespace plumb;
using namespace plumb::screen;

namespace {

double dot(const glm::dvec3& a, const glm::dvec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

// The largest solid that closed forms need: the half spaces below planes n.x = d, intersected by nothing.
struct Plane {
    glm::dvec3 normal;
    double offset;
};

// What a camera sees of planes: positions and normals.
struct Seen {
    Camera camera;
    glm::ivec2 size;
    View view;
    Image4 position, normal;

    Seen(const Camera& c, glm::ivec2 s, const std::vector<Plane>& planes)
        : camera(c), size(s), view(make_view(c, double(s.x) / s.y)), position(s.x, s.y), normal(s.x, s.y) {
        for (int y = 0; y < s.y; ++y)
            for (int x = 0; x < s.x; ++x) {
                const Ray ray = ray_through_pixel(c, s, {x, y});
                double nearest = 1e30;
                for (const Plane& p : planes) {
                    const double down = dot(p.normal, ray.direction), t = (p.offset - dot(p.normal, ray.origin)) / down;
                    if (!(down < 0) || t <= 0 || t >= nearest) continue;
                    nearest = t;
                    const glm::dvec3 at = ray.origin + ray.direction * t;
                    position(x, y) = glm::vec4(glm::vec3(at), float(linear_depth(c, at)));
                    normal(x, y) = glm::vec4(glm::vec3(p.normal), 1);
                }
            }
    }
};

// A point and its normal, at each of the 4 x 4 rotations.
struct Tile {
    Image4 position{4, 4}, normal{4, 4};
    Tile(const glm::dvec3& p, const glm::dvec3& n) {
        for (glm::vec4& texel : position.texels) texel = glm::vec4(glm::vec3(p), 1);
        for (glm::vec4& texel : normal.texels) texel = glm::vec4(glm::vec3(n), 1);
    }
};

// The occluded share that screen.ssao finds at a point, a mean over the rotations.
double occluded_at(const AoParams& params, const Seen& seen, const glm::dvec3& p, const glm::dvec3& n) {
    const Tile tile(p, n);
    Image4 summed;
    run(params, SsaoInputs{&tile.position, &tile.normal, &seen.position, seen.view, true, nullptr, nullptr}, {}, summed);
    double open = 0;
    for (const glm::vec4& texel : summed.texels) open += double(texel.z) / 16;
    return 1 - open;
}

// Looks at the origin, from above a floor y = 0 towards a wall at x = -1 and one at z = -1.
Camera looking_down(double height = 2, double back = 4) {
    Camera camera;
    camera.position = {back, height, 0.9 * back}, camera.look_at = {-0.6, 0.2, -0.6};
    camera.fov_y_deg = 40, camera.near = 0.05, camera.far = 100;
    return camera;
}

const Plane floor_plane{{0, 1, 0}, 0}, wall_x{{1, 0, 0}, -1}, wall_z{{0, 0, 1}, -1};

AoParams ssao_params(double radius, int samples = 64) {
    AoParams params;
    params.method = AoMethod::ssao;
    params.radius = float(radius), params.samples = samples, params.bias = float(1e-3 * radius);
    return params;
}

// The share of the half sphere's directions with a component above c along an axis of its base: (1 - c) / 2.
double beyond(double c) { return c < 1 ? (1 - c) / 2 : 0; }
// That with both components above c: their solid angle over 2 pi, by rows of equal height about the second axis.
double beyond_both(double c) {
    double sum = 0;
    const int rows = 20000;
    for (int i = 0; i < rows; ++i) {
        const double y = c + (1 - c) * (i + 0.5) / rows, r = std::sqrt(1 - y * y);
        // x = r cos(phi) > c; of the circle half lies in the half sphere.
        if (r > c) sum += std::acos(c / r) / M_PI / 2 * (1 - c) / rows;
    }
    return sum;
}
// The mean of f(c / t) over the distances t of `samples`.
template <class F>
double over_scales(int samples, double c, F f) {
    double sum = 0;
    for (int i = 0; i < samples; ++i) {
        const double share = double(i) / samples;
        sum += f(c / (0.1 + 0.9 * share * share)) / samples;
    }
    return sum;
}

double ray_occlusion(double c) { return (std::acos(c) - c * std::sqrt(1 - c * c)) / M_PI; }

// The last value of that name.
double explained(const std::vector<TapValue>& taps, const std::string& name) {
    double value = std::nan("");
    for (const TapValue& t : taps)
        if (t.name == name) value = t.value[0];
    return value;
}

}  // namespace

TEST_CASE("ao: the closed forms of a wall's half ball are those of verification.md", "[ao][LRA 4.2.3][analytic]") {
    CHECK(over_scales(64, 0.25, beyond) == Approx(0.1417).margin(5e-5));
    CHECK(over_scales(64, 0.5, beyond) == Approx(0.0465).margin(5e-5));
    CHECK(over_scales(1000000, 0.25, beyond) == Approx(0.1446).margin(5e-5));
    CHECK(over_scales(1000000, 0.5, beyond) == Approx(0.0484).margin(5e-5));
    CHECK(ray_occlusion(0.25) == Approx(0.3425).margin(5e-5));
    CHECK(ray_occlusion(0.5) == Approx(0.1955).margin(5e-5));
    CHECK(beyond_both(0) == Approx(0.25).margin(1e-4));
}

TEST_CASE("ao: samples lie in the half ball at their distances, uniformly by direction", "[ao][LRA 6.2.3][analytic]") {
    AoParams params = ssao_params(1, 256);
    const Buffer<float> samples = half_ball(params);
    REQUIRE(samples.size() == 1024);
    glm::dvec3 mean(0);
    double squares = 0;
    for (int i = 0; i < 256; ++i) {
        const glm::dvec3 s(samples[4 * i], samples[4 * i + 1], samples[4 * i + 2]);
        const double length = std::sqrt(dot(s, s)), share = i / 256.0;
        CHECK(length == Approx(0.1 + 0.9 * share * share).epsilon(1e-6));
        CHECK(s.z >= 0);
        mean = mean + s / length / 256.0, squares += s.z * s.z / (length * length) / 256;
    }
    // The mean direction of the half sphere is half its pole; the mean square of the height is a third.
    CHECK(mean.x == Approx(0).margin(0.02));
    CHECK(mean.y == Approx(0).margin(0.02));
    CHECK(mean.z == Approx(0.5).margin(0.01));
    CHECK(squares == Approx(1.0 / 3).margin(0.01));

    // Rotations: 16 angles, evenly around.
    const Buffer<float> turns = rotations(params);
    double x = 0, y = 0;
    for (int i = 0; i < 16; ++i) {
        x += turns[2 * i], y += turns[2 * i + 1];
        CHECK(turns[2 * i] * turns[2 * i] + turns[2 * i + 1] * turns[2 * i + 1] == Approx(1).margin(1e-6));
    }
    CHECK(x == Approx(0).margin(1e-6));
    CHECK(y == Approx(0).margin(1e-6));
}

TEST_CASE("ao: a plane is open, however it is seen", "[ao][LRA 4.2.3][analytic]") {
    const std::vector<double> heights = {6, 1, 0.25, 0.05};
    for (const double height : heights) {
        INFO("height " << height);
        const Seen seen(looking_down(height), {96, 64}, {floor_plane});
        Image4 summed;
        run(ssao_params(0.5), SsaoInputs{&seen.position, &seen.normal, &seen.position, seen.view, true, nullptr, nullptr}, {},
            summed);
        int covered = 0;
        for (std::size_t i = 0; i < summed.size(); ++i) {
            const bool is = seen.normal.texels[i].w > 0;
            covered += is;
            CHECK(summed.texels[i] == (is ? glm::vec4(1, 1, 1, 1) : glm::vec4(0)));
        }
        CHECK(covered > 1000);

        AoParams horizon = ssao_params(0.5);
        horizon.method = AoMethod::horizon, horizon.slices = 64, horizon.steps = 2;
        run(horizon, HorizonInputs{&seen.position, &seen.normal, seen.view, nullptr}, {}, summed);
        double worst = 0;
        for (std::size_t i = 0; i < summed.size(); ++i)
            if (seen.normal.texels[i].w > 0) worst = std::max(worst, std::abs(1 - double(summed.texels[i].z)));
        CHECK(worst < 3e-4);  // of a sum over slices: it falls with their square
    }
}

TEST_CASE("ao: the half ball beside a wall and in a corner", "[ao][LRA 4.2.3][analytic]") {
    const Seen wall(looking_down(), {768, 576}, {floor_plane, wall_x});
    const Seen corner(looking_down(), {768, 576}, {floor_plane, wall_x, wall_z});
    for (const double c : {0.002, 0.25, 0.5}) {
        INFO("c " << c);
        const double radius = 0.4;
        const glm::dvec3 by_wall(-1 + c * radius, 0, -0.3), in_corner(-1 + c * radius, 0, -1 + c * radius);
        const double one = over_scales(64, c, beyond), both = over_scales(64, c, beyond_both);
        CHECK(occluded_at(ssao_params(radius), wall, by_wall, {0, 1, 0}) == Approx(one).margin(0.006));
        const double many = 2 * over_scales(1024, c, beyond) - over_scales(1024, c, beyond_both);
        CHECK(2 * one - both == Approx(many).margin(0.02));
        CHECK(occluded_at(ssao_params(radius, 1024), corner, in_corner, {0, 1, 0}) == Approx(many).margin(0.004));
    }
    // 90 degrees and three planes, at their edge: a half, and three quarters.
    CHECK(over_scales(64, 0, beyond) == Approx(0.5));
    CHECK(2 * over_scales(64, 0, beyond) - over_scales(64, 0, beyond_both) == Approx(0.75).margin(1e-4));
}

TEST_CASE("ao: more samples converge to the half ball", "[ao][LRA 4.2.3][analytic]") {
    const Seen wall(looking_down(), {1536, 1152}, {floor_plane, wall_x});
    double before = 1;
    for (const int samples : {4, 32, 1024}) {
        const double found = occluded_at(ssao_params(0.4, samples), wall, {-1 + 0.1, 0, -0.3}, {0, 1, 0});
        const double error = std::abs(found - over_scales(1000000, 0.25, beyond));
        INFO(samples << " samples: " << found);
        CHECK(error < before);
        before = error;
    }
    CHECK(before < 0.002);
}

TEST_CASE("ao: horizons beside a wall and in a corner are what rays of that length find", "[ao][GTAO][analytic]") {
    const Seen wall(looking_down(), {768, 576}, {floor_plane, wall_x});
    const Seen corner(looking_down(), {768, 576}, {floor_plane, wall_x, wall_z});
    AoParams params = ssao_params(1);
    params.method = AoMethod::horizon, params.slices = 64, params.steps = 256;
    auto at = [&](const Seen& seen, double x, double z, double c) {
        // The pixel next to that point of the floor; the radius by its distance from the wall.
        const glm::dvec2 texel = raster::project_to_texels(seen.view, seen.size.y, {x, 0, z});
        const glm::ivec2 pixel(int(texel.x * seen.size.x / seen.size.y), int(texel.y));
        REQUIRE(seen.normal(pixel.x, pixel.y).y == 1);
        params.radius = float((double(seen.position(pixel.x, pixel.y).x) + 1) / c);
        return 1 - explained(explain(params, HorizonInputs{&seen.position, &seen.normal, seen.view, nullptr}, pixel), "open");
    };
    for (const double c : {0.25, 0.5}) {
        INFO("c " << c);
        CHECK(at(wall, -1 + c * 0.4, -0.3, c) == Approx(ray_occlusion(c)).margin(0.006));
    }
    // At the edge: a half; of three planes: three quarters.
    CHECK(at(wall, -1 + 0.01, -0.3, 0.02) == Approx(ray_occlusion(0.02)).margin(0.01));
    CHECK(at(corner, -1 + 0.01, -1 + 0.01, 0.02) == Approx(0.75).margin(0.02));
}

TEST_CASE("ao: the range check of a surface far before the point", "[ao][LRA 6.2.3]") {
    // A screen of 2 m hides half of what lies behind it; it stands 4 radii before the floor point, along the view.
    Camera camera;
    camera.position = {0, 5, 0}, camera.look_at = {0, 0, 0}, camera.up = {0, 0, -1}, camera.near = 0.1;
    const Seen low(camera, {64, 64}, {floor_plane}), high(camera, {64, 64}, {Plane{{0, 1, 0}, 2}});
    const glm::dvec3 p(0, 0, 0), n(0, 1, 0);
    CHECK(occluded_at(ssao_params(0.5), low, p, n) == 0);
    // R / |d_p - d_q| = 1/4: 3/16 - 2/64.
    CHECK(occluded_at(ssao_params(0.5), high, p, n) == Approx(3.0 / 16 - 2.0 / 64).epsilon(1e-5));
    CHECK(occluded_at(ssao_params(2), high, p, n) > 0.5);
}

// ---- Several views -----------------------------------------------------------------------------------------------------

namespace {

struct Summed {
    glm::vec4 own, both;
};

// The sums at a point: of the camera, and then of a light above it, which sees `of_light`.
Summed sums_at(AoParams params, const Seen& camera, const Seen& light, const glm::dvec3& p, const glm::dvec3& n) {
    params.views = AoViews::lights;
    const Tile tile(p, n);
    Image4 own, both;
    run(params, SsaoInputs{&tile.position, &tile.normal, &camera.position, camera.view, true, nullptr, nullptr}, {}, own);
    run(params, SsaoInputs{&tile.position, &tile.normal, &light.position, light.view, false, &own, nullptr}, {}, both);
    return {own(1, 2), both(1, 2)};
}

}  // namespace

TEST_CASE("ao: views are weighed by direction and distance, and not at all where they do not see", "[ao][LRA 4.3.2]") {
    const Seen camera(looking_down(), {256, 192}, {floor_plane});
    Camera above;
    above.position = {3, 4, 0}, above.look_at = {0, 0, 0}, above.fov_y_deg = 60, above.near = 0.1;
    const Seen light(above, {128, 128}, {floor_plane});
    const glm::dvec3 p(0, 0, 0), n(0, 1, 0);
    AoParams params = ssao_params(0.5);

    // Direction alone: the cosine to the eye, 4 of 5 m.
    params.weight_bias = 0;
    const Summed by_direction = sums_at(params, camera, light, p, n);
    CHECK(double(by_direction.both.y) - double(by_direction.own.y) == Approx(0.8).epsilon(1e-5));
    CHECK(by_direction.both.x == Approx(by_direction.both.y).epsilon(1e-6));  // open
    CHECK(by_direction.both.z == 1.0f);

    // Distance alone: one less the mean distance to what is fetched, over the radius: within the texels' size that of the
    // samples' projections to the floor.
    params.weight_bias = 1;
    const Buffer<float> samples = half_ball(params), turns = rotations(params);
    double distance = 0;
    for (int i = 0; i < 64; ++i) {
        const double c = turns[2 * (1 + 4 * 2)], s = turns[2 * (1 + 4 * 2) + 1];
        // n = y: the basis of Duff et al. is tangent (1, 0, 0), bitangent (0, 0, -1).
        const double x = samples[4 * i], y = samples[4 * i + 1];
        const glm::dvec3 at = 0.5 * glm::dvec3(x * c - y * s, samples[4 * i + 2], -(x * s + y * c));
        const double t = at.y / (4 - at.y);  // on to the floor, from the eye
        const glm::dvec3 q = at + t * (at - glm::dvec3(3, 4, 0));
        distance += std::min(std::sqrt(dot(q, q)), 0.5) / 64;
    }
    const Summed by_distance = sums_at(params, camera, light, p, n);
    CHECK(double(by_distance.both.y) - double(by_distance.own.y) == Approx(1 - distance / 0.5).margin(0.02));

    // A table between the light and the point; and a point that faces away.
    const Seen table(above, {128, 128}, {Plane{{0, 1, 0}, 1}});
    params.weight_bias = 0.25f;
    CHECK(sums_at(params, camera, table, p, n).both == sums_at(params, camera, table, p, n).own);
    CHECK(sums_at(params, camera, light, p, {0, -1, 0}).both.y == sums_at(params, camera, light, p, {0, -1, 0}).own.y);
    // Beyond the light's borders.
    CHECK(sums_at(params, camera, light, {-40, 0, 0}, n).both == sums_at(params, camera, light, {-40, 0, 0}, n).own);
}

TEST_CASE("ao: the mean over views is blurred over all 16 rotations alike, and not moved", "[ao][LRA 6.2.3]") {
    const glm::ivec2 size(24, 20);
    Image4 summed(size.x, size.y), position(size.x, size.y), normal(size.x, size.y), open;
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            const bool one = x % 4 == 1 && y % 4 == 2;
            summed(x, y) = {one ? 2 : 0, 2, 0.5f, 1};  // sum w o / sum w: 1 of 16
            position(x, y) = {float(x), float(y), 0, 10}, normal(x, y) = {0, 0, 1, 1};
        }
    AoParams params;
    for (const AoBlur blur : {AoBlur::box, AoBlur::edge_aware}) {
        params.blur = blur;
        run(params, BlurInputs{&summed, &position, &normal, nullptr}, {}, open);
        for (int y = 2; y < size.y - 2; ++y)
            for (int x = 2; x < size.x - 2; ++x) CHECK(open(x, y) == glm::vec4(0.0625f, 0.0625f, 0.0625f, 1));
    }
    // A ramp stays where it is; as printed it moves by half a pixel.
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) summed(x, y) = {float(x) / 32, 1, 0, 1};
    params.blur = AoBlur::box;
    run(params, BlurInputs{&summed, &position, &normal, nullptr}, {}, open);
    CHECK(open(9, 9).x == 9.0f / 32);
    params.variant = AoVariant::published;
    run(params, BlurInputs{&summed, &position, &normal, nullptr}, {}, open);
    CHECK(open(9, 9).x == 8.5f / 32);

    // No view has a weight: the receivers' own; without a surface 0; the background has no weight.
    params = {};
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) summed(x, y) = x < 10 ? glm::vec4(0, 0, 0.75f, 1) : glm::vec4(0);
    run(params, BlurInputs{&summed, &position, &normal, nullptr}, {}, open);
    CHECK(open(9, 9) == glm::vec4(0.75f, 0.75f, 0.75f, 1));
    CHECK(open(10, 9) == glm::vec4(0));
    params.blur = AoBlur::none;
    run(params, BlurInputs{&summed, &position, &normal, nullptr}, {}, open);
    CHECK(open(9, 9) == glm::vec4(0.75f, 0.75f, 0.75f, 1));
}

TEST_CASE("ao: what is left of light", "[ao]") {
    Image4 indirect(3, 1), open(3, 1), lit;
    indirect(0, 0) = {1, 2, 4, 7}, indirect(1, 0) = {INFINITY, 0, 0, 1}, indirect(2, 0) = {8, 8, 8, 0};
    open(0, 0) = {0.5f, 0.5f, 0.5f, 1}, open(2, 0) = {1, 1, 1, 1};
    AoParams params;
    params.ambient = {1, 0, 2};
    run(params, OccludeInputs{&indirect, &open}, {}, lit);
    CHECK(lit(0, 0) == glm::vec4(1, 1, 3, 7));
    CHECK(lit(1, 0) == glm::vec4(0, 0, 0, 1));  // no surface
    CHECK(lit(2, 0) == glm::vec4(9, 8, 10, 0));
}

TEST_CASE("ao: as printed a floor occludes itself, and depth is the world's z", "[ao][LRA 6.2.3][published]") {
    // Seen along +z, what the camera sees behind a sample has the larger z: the listing takes it for an occluder.
    AoParams params = ssao_params(0.5);
    params.variant = AoVariant::published;
    Camera along;
    along.position = {0, 2, -4}, along.look_at = {0, 0, 0}, along.near = 0.1;
    const Seen seen(along, {256, 192}, {floor_plane});
    CHECK(occluded_at(params, seen, {0, 0, 0}, {0, 1, 0}) > 0.9);
    CHECK(occluded_at(ssao_params(0.5), seen, {0, 0, 0}, {0, 1, 0}) == 0);
    // Looking along -z at a wall z = 0, world z is depth but for its sign: open.
    Camera front;
    front.position = {0, 0, 3}, front.look_at = {0, 0, 0}, front.near = 0.1;
    const Seen wall(front, {256, 256}, {Plane{{0, 0, 1}, 0}});
    CHECK(occluded_at(params, wall, {0, 0, 0}, {0, 0, 1}) == 0);
}

TEST_CASE("ao: what no range of one parameter says", "[ao][input]") {
    AoParams params;
    params.method = AoMethod::horizon, params.views = AoViews::lights;
    CHECK_THROWS_WITH(validate(params), Catch::Contains("views = lights with method = horizon"));
    params.views = AoViews::camera, params.variant = AoVariant::published;
    CHECK_THROWS_WITH(validate(params), Catch::Contains("variant = published with method = horizon"));
    params = {};
    params.radius = 0;
    CHECK_THROWS_WITH(validate(params), Catch::Contains("radius"));
}
