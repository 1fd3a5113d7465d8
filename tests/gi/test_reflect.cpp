// Reflections against closed forms: where mirrored rays meet planes, from images made in double.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/camera.h"
#include "core/error.h"
#include "gi/screen/screen.h"
#include "raster/light_view.h"

using namespace plumb;
using namespace plumb::screen;

namespace {

double dot(const glm::dvec3& a, const glm::dvec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
glm::dvec3 mirrored(const glm::dvec3& v, const glm::dvec3& n) { return v - n * (2 * dot(v, n)); }
glm::dvec3 unit(const glm::dvec3& v) { return v / std::sqrt(dot(v, v)); }

// A plane n.x = d that is seen from where n.x > d, where `holds` says that it is.
struct Plane {
    glm::dvec3 normal;
    double offset;
    bool mirror = false;
    bool (*holds)(const glm::dvec3&) = [](const glm::dvec3&) { return true; };
    double distance(const glm::dvec3& from, const glm::dvec3& along) const {
        return (offset - dot(normal, from)) / dot(normal, along);
    }
};

// What a camera sees of planes: positions, normals, mirrors.
struct Seen {
    Camera camera;
    glm::ivec2 size;
    View view;
    Image4 position, normal, mirror;

    Seen(const Camera& c, glm::ivec2 s, const std::vector<Plane>& planes)
        : camera(c), size(s), view(make_view(c, double(s.x) / s.y)), position(s.x, s.y), normal(s.x, s.y), mirror(s.x, s.y) {
        for (int y = 0; y < s.y; ++y)
            for (int x = 0; x < s.x; ++x) {
                const Ray ray = ray_through_pixel(c, s, {x, y});
                double nearest = 1e30;
                for (const Plane& p : planes) {
                    const double t = p.distance(ray.origin, ray.direction);
                    const glm::dvec3 at = ray.origin + ray.direction * t;
                    if (!(dot(p.normal, ray.direction) < 0) || !(t > 0) || t >= nearest || !p.holds(at)) continue;
                    nearest = t;
                    position(x, y) = glm::vec4(glm::vec3(at), float(linear_depth(c, at)));
                    normal(x, y) = glm::vec4(glm::vec3(p.normal), 1);
                    mirror(x, y) = p.mirror ? glm::vec4(1) : glm::vec4(0);
                }
            }
    }
    ReflectInputs inputs() const {
        ReflectInputs in;
        in.position = in.seen = &position, in.normal = in.seen_normal = &normal, in.mirror = &mirror;
        in.eye = camera.position, in.view = view;
        return in;
    }
    glm::dvec3 p(int x, int y) const { return glm::dvec3(glm::vec3(position(x, y))); }
    // The mirrored ray of a pixel of that normal.
    glm::dvec3 r(int x, int y) const {
        return mirrored(unit(p(x, y) - camera.position), glm::dvec3(glm::vec3(normal(x, y))));
    }
    glm::dvec2 texel_of(const glm::dvec3& at) const {
        const glm::dvec2 square = raster::project_to_texels(view, size.y, at);
        return {square.x * size.x / size.y, square.y};
    }
};

ReflectParams steps(float step = 0.1f, int count = 64) {
    ReflectParams params;
    params.march = March::steps, params.step = step, params.steps = count;
    return params;
}

Camera looking(const glm::dvec3& from, const glm::dvec3& at) {
    Camera camera;
    camera.position = from, camera.look_at = at, camera.fov_y_deg = 50, camera.near = 0.05, camera.far = 1e3;
    return camera;
}

const Plane floor_mirror{{0, 1, 0}, 0, true};
const Plane back_wall{{0, 0, 1}, -1};

// Runs the march that `params` say, over blocks as screen.nearest makes them.
void find(const ReflectParams& params, const ReflectInputs& in, Image4& hits) {
    if (params.march == March::steps) return run(params, in, {}, hits);
    Image4 nearest;
    run(params, NearestInputs{in.seen}, {}, nearest);
    run(params, CellsInputs{in, &nearest, nullptr}, {}, hits);
}

ReflectParams march_by(March march, float step = 0.1f, int count = 64) {
    ReflectParams params = steps(step, count);
    params.march = march, params.cells = 4096;
    return params;
}

int hits_of(const Image4& hits) {
    return int(std::count_if(hits.texels.begin(), hits.texels.end(), [](const glm::vec4& h) { return h.w != 0; }));
}

// How far hits are from where rays meet `plane`, over the pixels whose hit is on the picture, within reach, and higher above
// the floor than the bias and a texel.
struct Errors {
    int asked = 0, missed = 0;
    double texels = 0, distance = 0;  // the largest
};
Errors errors_of(const Seen& seen, const Image4& hits, const Plane& plane, double reach) {
    Errors e;
    for (int y = 0; y < seen.size.y; ++y)
        for (int x = 0; x < seen.size.x; ++x) {
            if (seen.mirror(x, y).w == 0) continue;
            const glm::dvec3 p = seen.p(x, y), r = seen.r(x, y);
            const double t = plane.distance(p, r);
            if (!(t > 0) || t > reach || (p + r * t).y < 0.035 || !plane.holds(p + r * t)) continue;
            const glm::dvec2 at = seen.texel_of(p + r * t);
            if (!(at.x > 1 && at.y > 1 && at.x < seen.size.x - 1 && at.y < seen.size.y - 1)) continue;
            ++e.asked;
            const glm::vec4 hit = hits(x, y);
            if (hit.w != 1) {
                ++e.missed;
                continue;
            }
            e.texels = std::max({e.texels, std::abs(hit.x + 0.5 - at.x), std::abs(hit.y + 0.5 - at.y)});
            e.distance = std::max(e.distance, std::abs(hit.z - t));
        }
    return e;
}

}  // namespace

TEST_CASE("reflect: a floor before a wall shows the wall where rays meet it", "[reflect][LRA 4.2.4][analytic]") {
    const Seen seen(looking({0.3, 1.2, 2.5}, {0, 0.5, -1}), {192, 160}, {floor_mirror, back_wall});
    Image4 hits;
    run(steps(), seen.inputs(), {}, hits);
    const Errors e = errors_of(seen, hits, back_wall, 6.3);
    CHECK(e.asked > 4000);
    CHECK(e.missed == 0);
    CHECK(e.texels <= 1);         // the texel's middle from where the ray meets it: half a texel, and the last halved step
    CHECK(e.distance < 0.03);     // the last halved step is 0.1 m / 256; depths are known half a texel of 2.1 cm beside
    // More halved steps end nearer, to what a texel is wide.
    ReflectParams coarse = steps();
    coarse.bisections = 0;
    run(coarse, seen.inputs(), {}, hits);
    const Errors of_steps = errors_of(seen, hits, back_wall, 6.3);
    CHECK(of_steps.missed == 0);
    CHECK(of_steps.distance > 0.09);
    CHECK(of_steps.distance < 0.11);
    // From texel to texel: where the ray is within a texel whose surface is known half a texel beside.
    find(march_by(March::hierarchical), seen.inputs(), hits);
    const Errors of_cells = errors_of(seen, hits, back_wall, 6.3);
    CHECK(of_cells.asked == e.asked);
    CHECK(of_cells.missed == 0);
    CHECK(of_cells.texels <= 1);
    CHECK(of_cells.distance < 0.03);
    // No farther than its steps reach.
    run(steps(0.1f, 10), seen.inputs(), {}, hits);
    for (const glm::vec4& hit : hits.texels) CHECK(hit.z <= 1.0f);
    CHECK(hits_of(hits) > 100);
}

TEST_CASE("reflect: a flat floor never meets itself, however it is seen", "[reflect][LRA 4.2.4][analytic]") {
    for (const double height : {6.0, 1.0, 0.25, 0.05}) {
        INFO("height " << height);
        const Seen seen(looking({0, height, 2}, {0, 0, -3}), {96, 64}, {floor_mirror});
        for (const March march : {March::steps, March::hierarchical})
            for (const float step : {0.001f, 0.1f, 3.0f}) {
                Image4 hits;
                find(march_by(march, step, 256), seen.inputs(), hits);
                CHECK(hits_of(hits) == 0);
            }
    }
}

TEST_CASE("reflect: a ray along a plane never meets it, before it or behind it", "[reflect][LRA 4.2.4][analytic]") {
    // Points that mirror rays along +x, beside a wall z = -1 that a camera sees from its front.
    const Seen seen(looking({0, 0, 3}, {0, 0, -1}), {64, 64}, {back_wall});
    for (const double z : {-0.5, -0.999, -1.001, -1.05, -1.5}) {
        INFO("z " << z);
        const glm::dvec3 p(-1, 0, z), n = unit(glm::dvec3(1, 0, 0) - unit(p - glm::dvec3(0, 0, 3)));
        Image4 position(1, 1), normal(1, 1), mirror(1, 1), hits;
        position(0, 0) = glm::vec4(glm::vec3(p), 1), normal(0, 0) = glm::vec4(glm::vec3(n), 1), mirror(0, 0) = glm::vec4(1);
        ReflectInputs in = seen.inputs();
        in.position = &position, in.normal = &normal, in.mirror = &mirror;
        for (const March march : {March::steps, March::hierarchical}) {
            find(march_by(march), in, hits);
            CHECK(hits(0, 0) == glm::vec4(0));
        }
    }
}

TEST_CASE("reflect: what lies behind the camera, beyond the picture or infinitely far is not met", "[reflect][LRA 4.2.4][analytic]") {
    // A mirror before the camera, which sends every ray back past it to a wall that it does not see.
    const Plane mirror{{0, 0, 1}, -1, true}, behind{{0, 0, -1}, -5};
    const Seen facing(looking({0, 0, 1}, {0, 0, -1}), {64, 48}, {mirror, behind});
    Image4 hits;
    for (const March march : {March::steps, March::hierarchical})
        for (const float step : {0.013f, 0.1f, 0.5f}) {
            find(march_by(march, step, 512), facing.inputs(), hits);
            CHECK(hits_of(hits) == 0);
        }
    // A floor under nothing: rays go to where nothing is, and on to the border.
    const Seen open(looking({0, 1, 3}, {0, 0, 0}), {64, 48}, {floor_mirror});
    for (const March march : {March::steps, March::hierarchical}) {
        find(march_by(march, 1000, 4096), open.inputs(), hits);
        CHECK(hits_of(hits) == 0);
    }
    // Points at the eye itself, and infinitely far.
    Image4 position(2, 1), normal(2, 1), all(2, 1);
    position(0, 0) = glm::vec4(0, 1, 3, 0), position(1, 0) = glm::vec4(0, 0, -INFINITY, INFINITY);
    normal(0, 0) = normal(1, 0) = glm::vec4(0, 1, 0, 1), all(0, 0) = all(1, 0) = glm::vec4(1);
    ReflectInputs in = open.inputs();
    in.position = &position, in.normal = &normal, in.mirror = &all;
    for (const March march : {March::steps, March::hierarchical}) {
        find(march_by(march), in, hits);
        CHECK(hits(0, 0) == glm::vec4(0));
        CHECK(hits(1, 0) == glm::vec4(0));
    }
}

TEST_CASE("reflect: blocks hold the least depth of their texels", "[reflect][Uludag 2014]") {
    for (const glm::ivec2 size : {glm::ivec2(1, 1), glm::ivec2(37, 23), glm::ivec2(64, 48), glm::ivec2(3, 200)}) {
        Image4 position(size.x, size.y), nearest;
        for (int i = 0; i < int(position.size()); ++i)
            if (i % 5 != 0) position.texels[std::size_t(i)].w = float((i * 7919) % 1009 + 1);
        run(steps(), NearestInputs{&position}, {}, nearest);
        REQUIRE(glm::ivec2(nearest.width, nearest.height) == blocks_of(size));
        int start = 0;
        for (int level = 1; level <= levels_of(size); ++level) {
            const int side = 1 << level, rows = padded_height(size) >> level;
            for (int y = 0; y < rows; ++y)
                for (int x = 0; x * side < size.x; ++x) {
                    float least = no_depth;
                    for (int v = y * side; v < std::min((y + 1) * side, size.y); ++v)
                        for (int u = x * side; u < std::min((x + 1) * side, size.x); ++u)
                            if (position(u, v).w > 0) least = std::min(least, position(u, v).w);
                    CHECK(nearest(x, start + y).x == least);
                }
            start += rows;
        }
        CHECK(start == nearest.height);
    }
}

TEST_CASE("reflect: from texel to texel nothing thin is passed over", "[reflect][McGuire and Mara 2014]") {
    // A post of 2 cm before the wall: of most rays that meet it no step of 0.3 m ends in it.
    const Plane post{{0, 0, 1}, -0.4, false, [](const glm::dvec3& x) { return std::abs(x.x) < 0.02 && x.y < 1; }};
    const Seen seen(looking({0, 1.2, 2.5}, {0, 0.5, -1}), {256, 200}, {floor_mirror, back_wall, post});
    const auto on_post = [&](const ReflectParams& params) {
        Image4 hits;
        find(params, seen.inputs(), hits);
        int n = 0;
        for (const glm::vec4& hit : hits.texels) n += hit.w == 1 && std::abs(seen.position(int(hit.x), int(hit.y)).z + 0.4f) < 1e-4f;
        return n;
    };
    ReflectParams by_steps = march_by(March::steps, 0.3f, 21), by_cells = march_by(March::hierarchical, 0.3f, 21);
    by_steps.thickness = by_cells.thickness = 0.2f;  // 6 cm
    int there = 0;
    for (int y = 0; y < seen.size.y; ++y)
        for (int x = 0; x < seen.size.x; ++x) {
            if (seen.mirror(x, y).w == 0) continue;
            const glm::dvec3 p = seen.p(x, y), r = seen.r(x, y);
            const double t = post.distance(p, r);
            there += t > 0.05 && t < 6 && post.holds(p + r * t);
        }
    const int cells = on_post(by_cells);
    INFO(there << " rays meet the post, by cells " << cells << ", by steps " << on_post(by_steps));
    CHECK(there > 100);
    CHECK(cells > 0.9 * there);
    CHECK(cells < 1.2 * there);
    CHECK(2 * on_post(by_steps) < cells);
    // So many texels a ray passes: no block is passed where there is one level's worth of them alone.
    ReflectParams few = by_cells;
    few.cells = 4;
    CHECK(on_post(few) < cells);
}

TEST_CASE("reflect: rays pass behind what is thin, and what turns its back", "[reflect][LRA 4.2.4]") {
    // A board stands between the camera and the wall, beside the rays: they go behind it.
    const Plane board{{0, 0, 1}, 0.6, false, [](const glm::dvec3& x) { return x.y > 0.35 && x.y < 0.6 && std::abs(x.x) < 0.4; }};
    const Seen seen(looking({0, 1, 3}, {0, 0.3, -1}), {192, 160}, {floor_mirror, back_wall, board});
    Image4 hits;
    run(steps(), seen.inputs(), {}, hits);
    const Errors wall = errors_of(seen, hits, back_wall, 6.3);
    CHECK(wall.asked > 3000);
    int behind = 0;
    for (int y = 0; y < seen.size.y; ++y)
        for (int x = 0; x < seen.size.x; ++x) {
            const glm::vec4 hit = hits(x, y);
            if (hit.w != 1 || seen.position(int(hit.x), int(hit.y)).z < 0.5f) continue;
            // Of the board: the ray met its front, on the way to it.
            const glm::dvec3 p = seen.p(x, y), at = p + seen.r(x, y) * double(hit.z);
            CHECK(p.z > 0.6);
            CHECK(std::abs(at.z - 0.6) < 0.12 * 1.3);
            ++behind;
        }
    CHECK(behind > 50);
    // Twice as thick as the rays are behind it, and it is met by rays that pass there.
    ReflectParams thick = steps();
    thick.thickness = 100;
    Image4 more;
    run(thick, seen.inputs(), {}, more);
    CHECK(hits_of(more) >= hits_of(hits));
}

TEST_CASE("reflect: the camera's hit stands, and of the maps' the nearest", "[reflect][LRA 4.3.1]") {
    const Seen seen(looking({0.3, 1.2, 2.5}, {0, 0.5, -1}), {48, 40}, {floor_mirror, back_wall});
    const March march = GENERATE(March::steps, March::hierarchical);
    Image4 found, hits;
    find(march_by(march), seen.inputs(), found);
    int x = 0, y = 0;
    for (int i = 0; i < int(found.size()); ++i)
        if (found.texels[std::size_t(i)].w == 1) x = i % 48, y = i / 48;
    REQUIRE(found(x, y).w == 1);
    Image4 before(48, 40);
    ReflectInputs in = seen.inputs();
    in.number = 3, in.before = &before;
    const glm::vec4 as_map(found(x, y).x, found(x, y).y, found(x, y).z, 3);
    struct Try {
        glm::vec4 before, after;
    };
    const float t = found(x, y).z;
    for (const Try& one : {Try{{0, 0, 0, 0}, as_map}, Try{{7, 8, t + 1, 2}, as_map}, Try{{7, 8, t, 2}, {7, 8, t, 2}},
                           Try{{7, 8, t + 1, 1}, {7, 8, t + 1, 1}}}) {
        before(x, y) = one.before;
        find(march_by(march), in, hits);
        CHECK(hits(x, y) == one.after);
    }
    // Where nothing is met what was found before goes on; no mirror meets nothing.
    const int none = int(std::find_if(found.texels.begin(), found.texels.end(), [](const glm::vec4& h) { return h.w == 0; }) - found.texels.begin());
    before = Image4(48, 40);
    before.texels[std::size_t(none)] = {1, 2, 3, 2};
    find(march_by(march), in, hits);
    CHECK(hits.texels[std::size_t(none)] == glm::vec4(1, 2, 3, 2));
}

TEST_CASE("reflect: a map sees what the camera does not", "[reflect][LRA 4.3.1][analytic]") {
    // The camera looks down at the floor; the wall is above its picture, and a lamp sees it.
    const Seen camera(looking({0, 1.5, 1}, {0, 0, 0}), {64, 48}, {floor_mirror});
    const Seen lamp(looking({0, 1, 4}, {0, 1, -1}), {128, 128}, {back_wall});
    ReflectInputs in = camera.inputs();
    in.seen = &lamp.position, in.seen_normal = &lamp.normal, in.view = lamp.view, in.number = 2;
    Image4 hits;
    find(march_by(GENERATE(March::steps, March::hierarchical)), in, hits);
    int met = 0;
    for (int y = 0; y < 48; ++y)
        for (int x = 0; x < 64; ++x) {
            const glm::dvec3 p = camera.p(x, y), r = camera.r(x, y);
            const double t = back_wall.distance(p, r);
            const glm::dvec2 at = lamp.texel_of(p + r * t);
            if (!(t > 0.05 && t < 6.3 && at.x > 1 && at.y > 1 && at.x < 127 && at.y < 127)) continue;
            ++met;
            CHECK(hits(x, y).w == 2);
            CHECK(std::abs(hits(x, y).x + 0.5 - at.x) <= 1);
            CHECK(std::abs(hits(x, y).y + 0.5 - at.y) <= 1);
            CHECK(std::abs(hits(x, y).z - t) < 0.02);
        }
    CHECK(met > 500);
}

TEST_CASE("reflect: what mirrors show", "[reflect][LRA 4.3.1]") {
    const glm::ivec2 size(4, 3);
    Image4 hit(size.x, size.y), mirror(size.x, size.y), composed(size.x, size.y), reflection, radiance;
    Image4 albedo(size.x, size.y), emission(size.x, size.y), direct(size.x, size.y);
    for (int i = 0; i < 12; ++i) composed.texels[std::size_t(i)] = glm::vec4(float(i), 2, 0, 0);
    hit(1, 1) = {3, 2, 2, 1};                         // the camera's: texel 11
    hit(2, 1) = {9, 9, 1, 2};                         // a map's
    hit(3, 1) = {9, 9, 1, 1};                         // outside of the picture: a dump that cannot be
    for (glm::vec4& k : mirror.texels) k = {0.5f, 1, 0.25f, 1};
    albedo(2, 1) = {0.5f, 0.25f, 1, 0}, direct(2, 1) = {4, 8, 2, 1}, emission(2, 1) = {1, 0, 2, 0};
    ReflectParams params = steps();
    run(params, MirrorInputs{&hit, &mirror, &composed, &albedo, &emission, &direct}, {}, reflection, radiance);
    CHECK(reflection(1, 1) == glm::vec4(5.5f, 2, 0, 1));
    CHECK(radiance(1, 1) == glm::vec4(5 + 5.5f, 4, 0, 0));
    const double pi = 3.14159265358979;
    CHECK(reflection(2, 1).x == Approx(0.5 * 3 / pi));  // k (rho E + M) / pi
    CHECK(reflection(2, 1).y == Approx(2 / pi));
    CHECK(reflection(2, 1).z == Approx(0.25 * 4 / pi));
    CHECK(reflection(0, 0) == glm::vec4(0));
    CHECK(radiance(0, 0) == composed(0, 0));
    CHECK(reflection(3, 1) == glm::vec4(0, 0, 0, 1));

    // Half of it is left at the distance that is given, and half a texel from the border a third of what 1.5 texels keep.
    params.attenuation = 2, params.fade = 0.5f;
    run(params, MirrorInputs{&hit, &mirror, &composed}, {}, reflection, radiance);
    CHECK(reflection(1, 1).x == Approx(5.5 / 2 / 3));
    CHECK(reflection(2, 1) == glm::vec4(0, 0, 0, 1));  // nothing is known of maps
}

TEST_CASE("reflect: as printed the camera's position is mirrored in place of the ray to the point", "[reflect][LRA 6.2.4][published]") {
    const Seen seen(looking({0.3, 1.2, 2.5}, {0, 0.5, -1}), {48, 40}, {floor_mirror, back_wall});
    ReflectParams params = steps();
    params.variant = ReflectVariant::published;
    const std::vector<TapValue> taps = explain(params, seen.inputs(), {24, 36});
    const auto r = std::find_if(taps.begin(), taps.end(), [](const TapValue& t) { return t.name == "r"; });
    REQUIRE(r != taps.end());
    const glm::dvec3 printed = mirrored(unit({0.3, 1.2, 2.5}), {0, 1, 0});
    for (int c = 0; c < 3; ++c) CHECK(r->value[std::size_t(c)] == Approx(printed[c]).margin(1e-6));
    // It goes into the floor, towards the camera: what it finds there is the floor.
    CHECK(printed.y < 0);
    Image4 hits;
    run(params, seen.inputs(), {}, hits);
    const Errors wall = errors_of(seen, hits, back_wall, 6.3);
    CHECK((wall.missed > wall.asked / 2 || wall.texels > 2));
}

TEST_CASE("reflect: what no range of one parameter says", "[reflect][input]") {
    ReflectParams params = steps();
    params.variant = ReflectVariant::published, params.views = ReflectViews::lights;
    CHECK_THROWS_WITH(validate(params), Catch::Contains("variant = published with views = lights"));
    params.views = ReflectViews::camera, params.march = March::hierarchical;
    CHECK_THROWS_WITH(validate(params), Catch::Contains("variant = published with march = hierarchical"));
    params = {};
    params.step = 0;
    CHECK_THROWS_WITH(validate(params), Catch::Contains("step"));
}
