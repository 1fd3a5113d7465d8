// "All + rays", VRSM fig. 5.1 (d): the sum over every texel with a shadow ray each, and subsets of it. Rays are those of
// brute_rays.h, so that no claim here stands on the ray tracer that a frame uses.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "brute_rays.h"
#include "core/error.h"
#include "core/hash.h"
#include "core/host_math.h"
#include "gi/rsm/all_rays.h"
#include "gi/rsm/all_rays_kernel.h"
#include "raster/gbuffer.h"
#include "raster/light_view.h"
#include "rsm_scenes.h"

using namespace plumb;
using namespace plumb::test;

namespace {

constexpr rsm::RayOffsets micrometre{1e-6f, 1e-6f};

struct Result {
    Image4 irradiance;
    rsm::RaysReport report;
};

rsm::GatherParams params_of(float max_rays) {
    rsm::GatherParams params;
    params.gather = rsm::Gather::all_rays;
    params.max_rays = max_rays;
    return params;
}
rsm::GatherInputs inputs_of(const Points& points, const RayQuery& rays, std::uint32_t seed = 1) {
    rsm::GatherInputs in{&points.position, &points.normal};
    in.seed = seed, in.rays = &rays, in.offsets = micrometre;
    return in;
}

Result all_rays(const Points& points, std::span<const raster::Rsm> maps, const RayQuery& rays, float max_rays = 0,
                std::uint32_t seed = 1, const RunOptions& options = {}) {
    Result r;
    rsm::run_maps(params_of(max_rays), inputs_of(points, rays, seed), maps, options, r.irradiance, &r.report);
    return r;
}

Image4 all(const Points& points, std::span<const raster::Rsm> maps) {
    rsm::GatherParams params;
    params.gather = rsm::Gather::all;
    Image4 irradiance;
    rsm::run_maps(params, {&points.position, &points.normal}, maps, {}, irradiance);
    return irradiance;
}

bool same_bits(const Image4& a, const Image4& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(glm::vec4)) == 0;
}
bool black(const Image4& a) { return same_bits(a, Image4(a.width, a.height)); }

// A lit wall in the plane z = 0, and points of a floor at y = -1 before it.
raster::Rsm lit_wall(int n) {
    return plane_map(n, [](double x, double y) { return 1 + 0.5 * x - 0.3 * y; });
}
Points floor_points(int width, int height) {
    Points points(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            points.position(x, y) = glm::vec4(2 * (x + 0.5f) / width - 1, -1, 0.3f + 1.5f * (y + 0.31f) / height, 0);
            points.normal(x, y) = glm::vec4(0, 1, 0, 1);
        }
    return points;
}

// A screen that stands on the floor between the two, in the plane z = 0.25.
const double left = -0.30171, right = 0.40193, top = -0.20237, screen_z = 0.25;
struct Screen : BruteRays {
    Screen() { add_quad({left, -1, screen_z}, {right, -1, screen_z}, {left, top, screen_z}); }
};
bool behind_screen(glm::dvec3 x, glm::dvec3 x_p) {
    const glm::dvec3 at = x + (x_p - x) * ((screen_z - x.z) / (x_p.z - x.z));
    return at.x > left && at.x < right && at.y > -1 && at.y < top;
}

}  // namespace

TEST_CASE("rsm.all_rays: where nothing is hidden it is rsm.all, to the bit", "[rsm][all_rays][VRSM (3.2)][bits]") {
    const raster::Rsm wall = lit_wall(20);
    const Points points = floor_points(19, 7);
    const BruteRays nothing;
    const Result r = all_rays(points, {&wall, 1}, nothing);
    CHECK(same_bits(r.irradiance, all(points, {&wall, 1})));
    CHECK(black(r.report.standard_error));
    CHECK(r.irradiance(3, 3).x > 0);
    // Every point and texel face each other: a ray for each pair.
    CHECK(r.report.traced == 19 * 7 * 400);
    CHECK(nothing.asked == r.report.traced);
    CHECK((r.report.points == 19 * 7 && r.report.lit == 400 && r.report.texels == 400 && r.report.asked == 400));
    CHECK(rsm::summary(r.report) == "all 400 lit texels a pixel, 53200 rays");
}

TEST_CASE("rsm.all_rays: a screen hides the texels whose segments cross it, and no others", "[rsm][all_rays][analytic]") {
    const raster::Rsm wall = lit_wall(20);
    const Points points = floor_points(19, 7);
    const Result r = all_rays(points, {&wall, 1}, Screen());
    int hidden = 0, seen = 0;
    for (std::size_t i = 0; i < points.position.size(); ++i) {
        const glm::dvec3 x(points.position.texels[i]);
        double sum = 0;
        for (int t = 0; t < 400; ++t) {
            const float* p = wall.records.data() + record_stride * t;
            const glm::dvec3 x_p(p[0], p[1], p[2]), d = x_p - x;
            const double d2 = d.x * d.x + d.y * d.y + d.z * d.z;
            const bool blocked = behind_screen(x, x_p);
            blocked ? ++hidden : ++seen;
            if (!blocked) sum += p[8] * d.y * -d.z / (d2 * d2) / host::pi;
        }
        CAPTURE(i, x.x, x.z);
        // One texel more or less moves the sum by 1e-3 or more of it.
        CHECK(r.irradiance.texels[i].x == Approx(sum).epsilon(1e-5).margin(0));
    }
    CHECK((hidden > 5000 && seen > 20000));
}

TEST_CASE("rsm.all_rays: a point in a closed box sees no light from outside", "[rsm][all_rays]") {
    const raster::Rsm wall = lit_wall(8);
    const Points points({0, -1, 1}, {0, 1, 0});
    BruteRays box;
    const double s = 0.1;
    for (int side = -1; side <= 1; side += 2) {
        const glm::dvec3 corner(-s * side, -1 - s * side, 1 - s * side), x(2 * s * side, 0, 0), y(0, 2 * s * side, 0),
            z(0, 0, 2 * s * side);
        box.add_quad(corner, corner + x, corner + y);
        box.add_quad(corner, corner + y, corner + z);
        box.add_quad(corner, corner + z, corner + x);
    }
    CHECK(all(points, {&wall, 1})(0, 0).x > 0.1);
    const Result r = all_rays(points, {&wall, 1}, box);
    CHECK(black(r.irradiance));
    CHECK(r.report.traced == 64);
}

TEST_CASE("rsm.all_rays: texels without flux or surface and those that look away need no ray", "[rsm][all_rays]") {
    const Points points({0, -1, 1}, {0, 1, 0});
    const BruteRays nothing;
    raster::Rsm wall = lit_wall(8);
    for (int x = 0; x < 8; ++x) {
        set_texel(wall, x, 0, {0, 0, 0}, {0, 0, 1}, glm::vec3(0));            // reflects nothing
        set_texel(wall, x, 1, {0, 0, 0}, {0, 0, 0}, glm::vec3(1));            // is nothing
        set_texel(wall, x, 2, {0, 0, 0}, {0, 0, -1}, glm::vec3(1));           // looks away
        set_texel(wall, x, 3, {0, -2, 0}, {0, 0, 1}, glm::vec3(0, 0, 1e-9));  // lies below the floor
    }
    const Result r = all_rays(points, {&wall, 1}, nothing);
    CHECK(r.report.lit == 48);
    CHECK(r.report.traced == 32);
    CHECK(same_bits(r.irradiance, all(points, {&wall, 1})));

    // No flux at all, and no map at all; with a limit, too.
    const raster::Rsm dark = empty_map(4), none;
    for (float limit : {0.0f, 1.0f})
        for (const raster::Rsm* map : {&dark, &none}) {
            const raster::Rsm maps[] = {*map, dark};
            const Result empty = all_rays(points, maps, nothing, limit);
            CHECK(black(empty.irradiance));
            CHECK((empty.report.traced == 0 && empty.report.lit == 0));
        }
    // No surface: no ray.
    const Result background = all_rays(Points(5, 5), {&wall, 1}, nothing);
    CHECK(black(background.irradiance));
    CHECK((background.report.traced == 0 && background.report.points == 0));
}

TEST_CASE("rsm.all_rays: what is not a number is not hidden", "[rsm][all_rays][extreme]") {
    raster::Rsm wall = lit_wall(8);
    Points points = floor_points(3, 2);
    points.position(1, 1).x = std::nanf("");
    CHECK(std::isnan(all_rays(points, {&wall, 1}, Screen()).irradiance(1, 1).x));
    CHECK(std::isfinite(all_rays(points, {&wall, 1}, Screen()).irradiance(0, 1).x));
    CHECK(std::isnan(all_rays(points, {&wall, 1}, Screen(), 100).irradiance(1, 1).x));
}

// ---- Self-shadowing -----------------------------------------------------------------------------------------------------

namespace {

// A closed box, turned and moved, with a lamp and a camera in it. Convex: nothing is hidden from anything.
Scene box_scene(LightType type, glm::dvec3 centre, double turn, double scale) {
    Scene s;
    s.name = "box";
    s.materials.resize(1);
    Mesh m;
    const glm::dvec3 half = glm::dvec3(1, 1.5, 2.25) * scale;
    const double sine = host::sin(turn), cosine = host::cos(turn);
    auto at = [&](double x, double y, double z) {
        const glm::dvec3 p = half * glm::dvec3(x, y, z), q(p.x * cosine - p.z * sine, p.y, p.x * sine + p.z * cosine);
        return glm::vec3(centre + glm::dvec3(q.x, q.y * cosine - q.z * sine, q.y * sine + q.z * cosine));
    };
    auto quad = [&](glm::vec3 a, glm::vec3 b, glm::vec3 c, glm::vec3 d) {
        const unsigned first = unsigned(m.vertices.size());
        for (glm::vec3 p : {a, b, c, d}) m.vertices.push_back({p, 0, glm::vec3(0), 0});
        m.triangles.push_back({first, first + 1, first + 2});
        m.triangles.push_back({first, first + 2, first + 3});
        m.material.insert(m.material.end(), 2, 0);
    };
    for (double i : {-1.0, 1.0}) {
        quad(at(i, -1, -1), at(i, 1, -1), at(i, 1, 1), at(i, -1, 1));
        quad(at(-1, i, -1), at(1, i, -1), at(1, i, 1), at(-1, i, 1));
        quad(at(-1, -1, i), at(1, -1, i), at(1, 1, i), at(-1, 1, i));
    }
    s.meshes.push_back(m);
    Light light;
    light.type = type;
    light.position = at(0.1, 0.3, 0.2);
    light.direction = normalize3<float>(glm::vec3(0.1f, -1, 0.2f));
    light.rsm_size = 16;
    s.lights = {light};
    s.camera.position = glm::dvec3(at(0.55, 0.4, 0.8));
    s.camera.look_at = glm::dvec3(at(-0.6, -0.5, -1));
    s.camera.near = 0.01 * scale, s.camera.far = 100 * scale;
    s.frame_size = {24, 17};
    return s;
}

struct Drawn {
    Points points{1, 1};
    std::vector<raster::Rsm> maps;
    rsm::RayOffsets offsets;
    BruteRays rays;

    Drawn(const Scene& s, const raster::Layout& layout) : Drawn(s, layout, flatten(s)) {}
    Drawn(const Scene& s, const raster::Layout& layout, const Geometry& g) : rays(g) {
        const raster::Surfaces surfaces = raster::prepare(s, g);
        glm::vec3 low, high;
        bounds(g, low, high);
        const View view = make_view(s.camera, double(s.frame_size.x) / s.frame_size.y, s.convention, s.frame_size);
        raster::GBuffer buffer;
        raster::draw_gbuffer(g, surfaces, view, s.frame_size, layout, {}, buffer);
        points.position = buffer.position, points.normal = buffer.normal;
        const std::vector<View> views = raster::light_views(s.lights[0], low, high);
        maps.resize(views.size());
        for (std::size_t i = 0; i < views.size(); ++i)
            raster::draw_rsm(g, surfaces, s.lights[0], views[i], layout, {}, maps[i]);
        offsets = rsm::ray_offsets(layout, low, high, view, s.frame_size);
    }

    Result run() const {
        rsm::GatherInputs in = inputs_of(points, rays);
        in.offsets = offsets;
        Result r;
        rsm::run_maps(params_of(0), in, maps, {}, r.irradiance, &r.report);
        return r;
    }
    // The largest distance of a position from the nearest triangle's plane, m.
    double off_the_walls() const {
        double worst = 0;
        for (const glm::vec4& p : points.position.texels) {
            double nearest = 1e300;
            for (std::size_t i = 0; i < rays.corners.size(); i += 3) {
                const glm::dvec3 n = BruteRays::cross(rays.corners[i + 1] - rays.corners[i],
                                                      rays.corners[i + 2] - rays.corners[i]);
                const double d = BruteRays::dot(n, glm::dvec3(p) - rays.corners[i]) / std::sqrt(BruteRays::dot(n, n));
                nearest = std::min(nearest, std::abs(d));
            }
            worst = std::max(worst, nearest);
        }
        return worst;
    }
};

struct Room {
    glm::dvec3 centre;
    double turn, scale;
};
const Room rooms[] = {{{0, 0, 0}, 0, 1},       {{0, 0, 0}, 0.7, 1},     {{30, -20, 50}, 0.3, 1},
                      {{3e4, 1e4, 2e4}, 0.3, 1}, {{0, 0, 0}, 0.4, 1e-3}, {{0, 0, 0}, 0.9, 1e4}};

}  // namespace

TEST_CASE("rsm.all_rays: no false shadow in a closed convex box, wherever and however large", "[rsm][all_rays][extreme]") {
    for (LightType type : {LightType::spot, LightType::point})
        for (const Room& room : rooms) {
            CAPTURE(int(type), room.centre.x, room.turn, room.scale);
            const Drawn drawn(box_scene(type, room.centre, room.turn, room.scale), raster::Layout::fp32);
            const Result r = drawn.run();
            CHECK(r.report.points == 24 * 17);
            CHECK(r.report.traced > 24 * 17 * 16 * 16 / 2);
            CHECK(same_bits(r.irradiance, all(drawn.points, drawn.maps)));
        }
}

TEST_CASE("rsm.all_rays: positions lie off their surfaces by less than rays keep off", "[rsm][all_rays]") {
    for (const raster::Layout& layout : {raster::Layout::fp32, raster::Layout::rgba16f, raster::Layout::isr}) {
        double largest = 0;
        for (const Room& room : rooms) {
            // Halves have no numbers for the large and the far rooms.
            if (layout != raster::Layout::fp32 && (room.scale > 1 || room.centre.x > 100)) continue;
            CAPTURE(layout.name, room.centre.x, room.turn, room.scale);
            const Drawn drawn(box_scene(LightType::spot, room.centre, room.turn, room.scale), layout);
            const double off = drawn.off_the_walls();
            CHECK(off <= drawn.offsets.receiver);
            largest = std::max(largest, off / drawn.offsets.receiver);
        }
        // And not by so little that the offset could be a fraction of it.
        CAPTURE(layout.name, largest);
        CHECK(largest > 0.05);
    }
}

TEST_CASE("rsm.all_rays: half positions leave no false shadow on flat walls but at their edges", "[rsm][all_rays]") {
    const Drawn drawn(box_scene(LightType::point, {0, 0, 0}, 0.7, 1), raster::Layout::rgba16f);
    const Image4 with = drawn.run().irradiance, without = all(drawn.points, drawn.maps);
    double lost = 0, sum = 0;
    for (std::size_t i = 0; i < with.size(); ++i) {
        lost += double(without.texels[i].x) - with.texels[i].x;
        sum += without.texels[i].x;
    }
    CHECK(lost >= 0);
    CHECK(lost / sum < 1e-3);
}

TEST_CASE("rsm.all_rays: six faces are added as rsm.all adds them; a face may be missing", "[rsm][all_rays][point][bits]") {
    Drawn drawn(box_scene(LightType::point, {0, 0, 0}, 0.7, 1), raster::Layout::fp32);
    drawn.maps[2] = {};
    drawn.maps[5] = {};
    const Result r = drawn.run();
    CHECK(r.report.texels == 4 * 16 * 16);
    CHECK(same_bits(r.irradiance, all(drawn.points, drawn.maps)));
}

TEST_CASE("rsm.all_rays: a point that rounding put behind the wall of its crease is not hidden", "[rsm][all_rays]") {
    // Half a micrometre behind, where rays keep off by one: floor y = 0, walls x = 0 and x = 1.
    BruteRays room;
    room.add_quad({0, 0, -1}, {0, 0, 1}, {0, 2, -1});
    room.add_quad({0, 0, -1}, {1, 0, -1}, {0, 0, 1});
    raster::Rsm map = empty_map(1);
    set_texel(map, 0, 0, {1, 1, 0}, {-1, 0, 0}, glm::vec3(1));
    CHECK(all_rays(Points({-5e-7f, 0, 0}, {0, 1, 0}), {&map, 1}, room).irradiance(0, 0).x > 0.05);
    // The same for a texel at the foot of its wall.
    set_texel(map, 0, 0, {1, -5e-7f, 0}, {-1, 0, 0}, glm::vec3(1));
    CHECK(all_rays(Points({0, 1, 0}, {1, 0, 0}), {&map, 1}, room).irradiance(0, 0).x > 0.05);
    // Four times as far behind it is: the surfaces are where they are.
    CHECK(black(all_rays(Points({-2e-6f, 0, 0}, {0, 1, 0}), {&map, 1}, room).irradiance));
}

// ---- Subsets ------------------------------------------------------------------------------------------------------------

TEST_CASE("rsm.all_rays: max_rays gives each point 16 times a power of two of texels", "[rsm][all_rays]") {
    auto asked = [](float limit, std::uint64_t points, std::uint64_t texels) {
        return rsm::texels_asked(params_of(limit), points, texels);
    };
    CHECK(asked(0, 1'000'000, 262'144) == 262'144);
    CHECK(asked(1e9f, 1000, 262'144) == 262'144);
    CHECK(asked(1e9f, 1 << 20, 262'144) == 512);  // 953.7 rays a point
    CHECK(asked(1e6f, 1 << 20, 262'144) == 16);   // never fewer
    CHECK(asked(1e6f, 1 << 20, 9) == 9);
    CHECK(asked(0x1p28f, 1 << 20, 262'144) == 256);
    CHECK(asked(0x1p28f, 1 << 20, 256) == 256);
}

namespace {

// Points before a wall of uneven flux and a screen; texels of very different flux.
raster::Rsm uneven_wall() {
    raster::Rsm map = plane_map(23, [](double x, double y) { return x > 0.2 && y < 0.1 ? 20 : 1.1 + x * y; });
    for (std::size_t i = 0; i < map.records.size(); i += record_stride) map.records[i + 9] *= 0.5f + 0.4f * map.records[i];
    return map;
}

}  // namespace

TEST_CASE("rsm.all_rays: a subset's mean is the complete sum, and its standard error is honest", "[rsm][all_rays]") {
    const raster::Rsm maps[] = {uneven_wall(), lit_wall(9)};
    Points points = floor_points(8, 4);
    for (glm::vec4& p : points.position.texels) p.z += 0.6f;  // not wholly in the screen's shadow
    const Screen screen;
    const Image4 truth = all_rays(points, maps, screen).irradiance;
    const int seeds = 300;
    for (int texels : {16, 64}) {
        std::vector<double> mean(32 * 2), squares(32 * 2);
        int within_1 = 0, within_3 = 0, n = 0;
        for (int seed = 0; seed < seeds; ++seed) {
            const Result r = all_rays(points, maps, screen, float(32 * texels), std::uint32_t(seed));
            REQUIRE(r.report.asked == std::uint64_t(texels));
            REQUIRE(r.report.traced <= std::uint64_t(32 * texels));
            for (std::size_t i = 0; i < 64; ++i) {
                const int c = int(i % 2);
                const double e = r.irradiance.texels[i / 2][c], error = r.report.standard_error.texels[i / 2][c];
                REQUIRE(error > 0);
                const double z = std::abs(e - truth.texels[i / 2][c]) / error;
                within_1 += z < 1, within_3 += z < 3, ++n;
                mean[i] += e / seeds, squares[i] += e * e / seeds;
            }
        }
        // 64 means over 300 seeds: each within 4.5 of its own standard errors, and together without a bias.
        double sum = 0;
        for (std::size_t i = 0; i < 64; ++i) {
            const double error = std::sqrt((squares[i] - mean[i] * mean[i]) / seeds);
            const double z = (mean[i] - truth.texels[i / 2][int(i % 2)]) / error;
            CAPTURE(texels, i, z);
            CHECK(std::abs(z) < 4.5);
            sum += z;
        }
        // The two channels of a point go together: 32 independent values at least.
        CHECK(std::abs(sum) < 3.5 * 64 / std::sqrt(32.0));
        // Student's t with 15 degrees of freedom has 66.7 % within 1 and 99.1 % within 3; skew costs a little.
        CAPTURE(texels, within_1, within_3, n);
        CHECK(double(within_1) / n == Approx(0.667).margin(0.03));
        CHECK(double(within_3) / n > 0.98);
        CHECK(double(within_3) / n < 0.999);
    }
}

TEST_CASE("rsm.all_rays: a standard error keeps its digits whatever the estimates' size and however near they are",
          "[rsm][all_rays][extreme]") {
    // 1 to 16: a variance of 136 / 6 for 16 numbers, over 16 of them (n (n + 1) / 12 for 1 to n).
    float ramp[rsm::replicates], scaled[rsm::replicates], same[rsm::replicates], near[rsm::replicates];
    const double expected = std::sqrt(16.0 * 17.0 / 12 / 16);
    for (int r = 0; r < rsm::replicates; ++r) ramp[r] = float(r + 1), same[r] = 0.1f, near[r] = 1 + float(r) * 0x1p-23f;
    CHECK(rsm::standard_error_of_mean<float>(ramp) == Approx(expected).epsilon(1e-6));
    // Squares of these would overflow, or vanish. Powers of two change no bit.
    for (const float by : {0x1p100f, 0x1p-100f}) {
        for (int r = 0; r < rsm::replicates; ++r) scaled[r] = ramp[r] * by;
        CHECK(rsm::standard_error_of_mean<float>(scaled) == rsm::standard_error_of_mean<float>(ramp) * by);
    }
    // The sum of 16 tenths rounds, and so does their mean; they do not differ.
    CHECK(rsm::standard_error_of_mean<float>(same) == 0);
    CHECK(rsm::standard_error_of_mean<float>(near) == Approx(expected * 0x1p-23).epsilon(1e-6));
    ramp[3] = NAN;
    CHECK(std::isnan(rsm::standard_error_of_mean<float>(ramp)));
}

TEST_CASE("rsm.all_rays: more texels err less, and flux decides which", "[rsm][all_rays]") {
    const raster::Rsm map = uneven_wall();
    const Points points = floor_points(16, 8);
    auto error = [&](int texels) {
        const Result r = all_rays(points, {&map, 1}, Screen(), float(128 * texels));
        REQUIRE(r.report.asked == std::uint64_t(texels));
        double sum = 0;
        for (const glm::vec4& e : r.report.standard_error.texels) sum += double(e.x) * e.x;
        return std::sqrt(sum / 128);
    };
    // Strata along a curve do better than the slope of -1/2 of chance: 4 times the texels, less than half the error.
    const double e16 = error(16), e64 = error(64), e256 = error(256);
    CAPTURE(e16, e64, e256);
    CHECK(e64 < 0.5 * e16);
    CHECK(e256 < 0.5 * e64);

    // One texel that has 99.6 % of the flux is chosen by all 16 samples of 94 % of the points, which then know no error.
    raster::Rsm lamp = lit_wall(23);
    for (int c = 8; c < 11; ++c) lamp.records[record_stride * 300 + c] = 1e3f;
    const BruteRays nothing;
    const Result r = all_rays(points, {&lamp, 1}, nothing, 128 * 16);
    int sure = 0;
    for (std::size_t i = 0; i < 128; ++i)
        sure += r.report.standard_error.texels[i].x < 0.01 * r.irradiance.texels[i].x;
    CHECK(sure > 128 * 0.85);
}

TEST_CASE("rsm.all_rays: a texel whose flux is almost nothing is still counted", "[rsm][all_rays]") {
    // Half of the texels have 1e-30 of the flux: chosen once in 2^31 each, and harmless.
    raster::Rsm map = lit_wall(16);
    for (std::size_t i = 0; i < map.records.size(); i += 2 * record_stride)
        for (std::size_t c = 8; c < 11; ++c) map.records[i + c] *= 1e-30f;
    const Points points = floor_points(8, 4);
    const BruteRays nothing;
    const Image4 truth = all(points, {&map, 1});
    const Result r = all_rays(points, {&map, 1}, nothing, 32 * 64);
    REQUIRE(r.report.lit == 256);
    for (std::size_t i = 0; i < 32; ++i)
        CHECK(std::abs(r.irradiance.texels[i].x - truth.texels[i].x) < 5 * r.report.standard_error.texels[i].x);
}

// ---- Bits, explanations, bad input --------------------------------------------------------------------------------------

TEST_CASE("rsm.all_rays: the same bits for every instruction set and thread count", "[rsm][all_rays][bits]") {
    raster::Rsm maps[] = {uneven_wall(), lit_wall(5)};
    for (glm::ivec2 size : {glm::ivec2(1, 1), glm::ivec2(3, 2), glm::ivec2(17, 5), glm::ivec2(9, 11)})
        for (float limit : {0.0f, 64.0f * float(size.x * size.y)}) {
            const Points points = floor_points(size.x, size.y);
            const Screen screen;
            RunOptions options;
            options.isa = Isa::scalar, options.threads = 1;
            const Result truth = all_rays(points, maps, screen, limit, 7, options);
            for (Isa isa : supported_isas())
                for (int threads : {1, 2, 3}) {
                    options.isa = isa, options.threads = threads;
                    CAPTURE(size.x, size.y, limit, isa_name(isa), threads);
                    const Result r = all_rays(points, maps, screen, limit, 7, options);
                    CHECK(same_bits(r.irradiance, truth.irradiance));
                    CHECK(same_bits(r.report.standard_error, truth.report.standard_error));
                    CHECK(r.report.traced == truth.report.traced);
                }
            CHECK(truth.report.asked == (limit > 0 ? 64 : 23 * 23 + 25));
        }
}

TEST_CASE("rsm.all_rays: explain ends with the picture's values and tells every ray", "[rsm][all_rays][explain]") {
    const raster::Rsm map = lit_wall(9);
    const Points points = floor_points(8, 4);
    const Screen screen;
    for (float limit : {0.0f, 32.0f * 32}) {
        const Result r = all_rays(points, {&map, 1}, screen, limit);
        const auto values = rsm::explain_maps(params_of(limit), inputs_of(points, screen), {&map, 1}, {5, 1});
        REQUIRE(values.back().name == "irradiance");
        for (int c = 0; c < 3; ++c) CHECK(float(values.back().value[std::size_t(c)]) == r.irradiance(5, 1)[c]);
        int samples = 0, seen = 0, hidden = 0;
        double sum = 0, flux = 0, form = 0, weight = 1;
        for (const TapValue& v : values) {
            if (v.sample < 0) continue;
            samples = std::max(samples, v.sample + 1);
            if (v.name == "flux") flux = v.value[0];
            if (v.name == "weight") weight = v.value[0];
            if (v.name == "form") form = v.value[0];
            if (v.name == "visible") {
                v.value[0] == 1 ? ++seen : ++hidden;
                sum += v.value[0] * flux * form * weight;
            }
        }
        CHECK(samples == (limit > 0 ? 32 : 81));
        CHECK(seen + hidden == samples);
        CHECK((seen > 0 && hidden > 0));
        CHECK(sum / host::pi / (limit > 0 ? 16 : 1) == Approx(r.irradiance(5, 1).x).epsilon(1e-5));
    }
}

TEST_CASE("rsm.all_rays: without rays, or with a map of half records, it says so or agrees", "[rsm][all_rays]") {
    raster::Rsm map = lit_wall(8);
    const Points points = floor_points(4, 3);
    const Screen screen;
    rsm::GatherInputs in = inputs_of(points, screen);
    in.rays = nullptr;
    Image4 out;
    CHECK_THROWS_WITH(rsm::run_maps(params_of(0), in, {&map, 1}, {}, out), "rsm.all_rays: rays must be bound");
    rsm::GatherParams negative = params_of(-1);
    in.rays = &screen, in.rsm = &map;
    CHECK_THROWS_AS(rsm::run(negative, in, {}, out), InputError);

    rsm::run(params_of(0), in, {}, out);
    CHECK(same_bits(out, all_rays(points, {&map, 1}, screen).irradiance));
    map.half = true;
    map.half_records.resize(map.records.size());
    for (std::size_t i = 0; i < map.records.size(); ++i) {
        map.half_records[i] = float_to_half(map.records[i]);
        map.records[i] = half_to_float(map.half_records[i]);
    }
    const Image4 halves = all_rays(points, {&map, 1}, screen).irradiance;
    map.half = false;
    CHECK(same_bits(halves, all_rays(points, {&map, 1}, screen).irradiance));
}
