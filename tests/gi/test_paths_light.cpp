// What the visibility of rsm.paths hides, and what it does not (VRSM 3.3): surfaces that are seen whole, a wall before a
// lit patch, and maps that hold nothing.
#include <catch2/catch.hpp>
#include <fmt/format.h>

#include <cstring>

#include "brute_rays.h"
#include "core/hash.h"
#include "core/host_math.h"
#include "raster/light_view.h"
#include "rsm_scenes.h"

using namespace plumb;
using namespace plumb::test;

namespace {

rsm::GatherParams paths_params(rsm::Visibility visibility = rsm::Visibility::algorithm_6, int slots = 5) {
    rsm::GatherParams params;
    params.gather = rsm::Gather::paths;
    params.visibility = visibility, params.slots = slots;
    return params;
}

Image4 gathered(const rsm::GatherParams& params, const Points& points, const raster::Rsm& map) {
    const rsm::Pattern pattern = rsm::pattern_of(params, map.size, 1);
    return gather(params, points, map, &pattern);
}

// The share of the samples inside of the map that are hidden.
double hidden_share(const rsm::GatherParams& params, const Points& points, const raster::Rsm& map) {
    const rsm::Pattern pattern = rsm::pattern_of(params, map.size, 1);
    const rsm::GatherInputs in{&points.position, &points.normal, &map, &pattern, 1};
    double hidden = 0, samples = 0;
    for (int y = 0; y < points.position.height; ++y)
        for (int x = 0; x < points.position.width; ++x) {
            bool inside = false;
            for (const TapValue& v : rsm::explain(params, in, {x, y})) {
                if (v.name == "inside") inside = v.value[0] != 0;
                if (v.name == "visibility" && inside) ++samples, hidden += v.value[0] == 0;
            }
        }
    REQUIRE(samples > 0);
    return hidden / samples;
}

float noise(int x, int y) { return unit_float<float>(pixel_hash<std::int32_t>(x, y, 3, 11).x); }

// A floor at z = 0 under a light that looks down on it, its heights off by the last digit of a coordinate near 1.
raster::Rsm floor_map(int size) {
    raster::Rsm map = plane_map(size, [](double x, double y) { return 1 + 0.5 * x - 0.2 * y; });
    for (int i = 0; i < size * size; ++i)
        map.records[std::size_t(i) * record_stride + 2] = 0x1p-23f * (noise(i, 0) - 0.5f);
    return map;
}

// Points of that floor, and of a wall of it at x = 0.3 that faces -x. Seen from above they are off the texels' centres.
Points floor_points() {
    Points points(6, 6);
    for (int i = 0; i < 36; ++i) {
        points.position.texels[i] = glm::vec4(0.6f * noise(i, 1) - 0.3f, 0.6f * noise(i, 2) - 0.3f, 0, 0);
        points.normal.texels[i] = glm::vec4(0, 0, 1, 1);
    }
    return points;
}
Points wall_points() {
    Points points(6, 6);
    for (int i = 0; i < 36; ++i) {
        points.position.texels[i] = glm::vec4(0.3f, 0.6f * noise(i, 1) - 0.3f, 0.02f + 0.5f * noise(i, 2), 0);
        points.normal.texels[i] = glm::vec4(-1, 0, 0, 1);
    }
    return points;
}

// A floor at z = 0 and a wall on it, the plane x = 0 for |y| < 1 and z < wall_height, under a sun that shines down
// along (-1, 0, -1): the wall's shadow ends at x = -wall_height. Beyond it lies a red patch; the floor on the lit side
// sends blue, the wall's lit side green.
constexpr double wall_height = 0.8;
raster::Rsm wall_map(int size) {
    Light sun;
    sun.type = LightType::directional;
    sun.direction = glm::normalize(glm::vec3(-1, 0, -1));
    raster::Rsm map = empty_map(size);
    map.type = sun.type;
    map.view = raster::light_view(sun, {-1.6f, -1, 0}, {0.8f, 1, 0.8f});
    const glm::dmat4 to_world = glm::inverse(map.view.world_to_clip());
    auto world = [&](int i, int j, double depth) {
        const glm::dvec4 p = to_world * glm::dvec4((2 * i + 1.0) / size - 1, (2 * j + 1.0) / size - 1, depth, 1);
        return glm::dvec3(p.x, p.y, p.z) / p.w;
    };
    const glm::dvec3 right = world(1, 0, 0.5) - world(0, 0, 0.5), down = world(0, 1, 0.5) - world(0, 0, 0.5);
    const double area = std::sqrt((right.x * right.x + right.y * right.y + right.z * right.z) *
                                  (down.x * down.x + down.y * down.y + down.z * down.z));
    for (int j = 0; j < size; ++j)
        for (int i = 0; i < size; ++i) {
            const glm::dvec3 o = world(i, j, 0.5), d(map.view.forward);
            const glm::dvec3 on_floor = o - d * (o.z / d.z), on_wall = o - d * (o.x / d.x);
            const bool inside = std::abs(on_floor.y) < 1 && on_floor.x > -1.6 && on_floor.x < 0.8;
            if (std::abs(on_wall.y) < 1 && on_wall.z > 0 && on_wall.z < wall_height)
                set_texel(map, i, j, glm::vec3(on_wall), {1, 0, 0}, glm::vec3(0, area, 0));
            else if (inside)
                set_texel(map, i, j, glm::vec3(on_floor), {0, 0, 1},
                          on_floor.x < -wall_height ? glm::vec3(area, 0, 0) : glm::vec3(0, 0, area));
        }
    return map;
}
struct WallRays : BruteRays {
    WallRays() {
        add_quad({0, -1, 0}, {0, 1, 0}, {0, -1, wall_height});
        add_quad({-1.6, -1, 0}, {0.8, -1, 0}, {-1.6, 1, 0});
    }
};

Image4 all_rays(const Points& points, const raster::Rsm& map) {
    rsm::GatherParams params;
    params.gather = rsm::Gather::all_rays;
    params.max_rays = 0;
    const WallRays rays;
    rsm::GatherInputs in{&points.position, &points.normal};
    in.rays = &rays, in.offsets = {1e-6f, 1e-6f};
    Image4 irradiance;
    rsm::run_maps(params, in, {&map, 1}, {}, irradiance);
    return irradiance;
}

bool black(const Image4& image) {
    const Image4 nothing(image.width, image.height);
    return std::memcmp(image.data(), nothing.data(), nothing.size() * sizeof(glm::vec4)) == 0;
}

}  // namespace

TEST_CASE("rsm.paths: Algorithm 2 darkens a floor that Algorithms 3 and 6 leave alone",
          "[rsm][paths][VRSM 3.3][analytic]") {
    // Fig. 3.4. From a point of the floor all of it lies at elevation 0, in one slot: the first sample hides the other
    // nine.
    const raster::Rsm map = floor_map(64);
    rsm::GatherParams params = paths_params();
    params.steps = 10;
    CHECK(hidden_share(params, floor_points(), map) == 0);
    params.visibility = rsm::Visibility::algorithm_3;
    CHECK(hidden_share(params, floor_points(), map) == 0);
    params.visibility = rsm::Visibility::algorithm_2;
    CHECK(hidden_share(params, floor_points(), map) == Approx(0.9).margin(1e-9));
    params.visibility = rsm::Visibility::none;
    CHECK(hidden_share(params, floor_points(), map) == 0);
}

TEST_CASE("rsm.paths: an even number of slots has an edge where floors lie", "[rsm][paths][VRSM 3.3]") {
    // The last digit of a height decides between two slots, which take each other's samples away.
    const raster::Rsm map = floor_map(64);
    for (int slots = 2; slots <= 32; ++slots) {
        const double share = hidden_share(paths_params(rsm::Visibility::algorithm_6, slots), floor_points(), map);
        INFO(fmt::format("{} slots: {:.1f} % hidden", slots, 100 * share));
        if (slots % 2 == 1) CHECK(share == 0);
        if (slots % 2 == 0) CHECK(share > 0.2);
    }
}

TEST_CASE("rsm.paths: a wall sees its whole floor, under Algorithm 6", "[rsm][paths][VRSM 3.3]") {
    // Along a path the floor rises from below towards elevation 0 and never comes back to a slot.
    const raster::Rsm map = floor_map(256);
    const Points points = wall_points();
    rsm::GatherParams params = paths_params();
    params.jitter = 0;
    for (int slots : {3, 5, 9, 17}) {
        params.slots = slots;
        params.visibility = rsm::Visibility::algorithm_6;
        CHECK(hidden_share(params, points, map) == 0);
        const Image4 by6 = gathered(params, points, map);
        params.visibility = rsm::Visibility::none;
        const Image4 none = gathered(params, points, map);
        CHECK(std::memcmp(by6.data(), none.data(), none.size() * sizeof(glm::vec4)) == 0);
        params.visibility = rsm::Visibility::algorithm_2;
        const double share = hidden_share(params, points, map);
        const Image4 by2 = gathered(params, points, map);
        double lost = 0, all = 0;
        for (std::size_t i = 0; i < by2.size(); ++i) lost += none.texels[i].x - by2.texels[i].x, all += none.texels[i].x;
        INFO(fmt::format("{} slots: Algorithm 2 hides {:.1f} % of the samples and {:.1f} % of the light", slots,
                         100 * share, 100 * lost / all));
        CHECK(share > (slots < 10 ? 0.3 : 0.1));
    }
    // Jitter and the rounding to texels may swap neighbours on the border of two slots.
    params = paths_params();
    CHECK(hidden_share(params, points, map) < 0.01);
}

TEST_CASE("rsm.paths: elevation is measured along the light's axis", "[rsm][paths][VRSM 3.3]") {
    const raster::Rsm map = wall_map(32);
    const Points points({0.5f, 0.1f, 0.3f}, {-1, 0, 0});
    const rsm::GatherParams params = paths_params();
    const rsm::Pattern pattern = rsm::pattern_of(params, map.size, 1);
    const rsm::GatherInputs in{&points.position, &points.normal, &map, &pattern, 1};
    glm::dvec3 x_p(0);
    int checked = 0;
    for (const TapValue& v : rsm::explain(params, in, {0, 0})) {
        if (v.name == "x_p") x_p = {v.value[0], v.value[1], v.value[2]};
        if (v.name != "dz") continue;
        // Up along (1, 0, 1) / sqrt 2, towards the sun.
        CHECK(v.value[0] == Approx((x_p.x - 0.5 + x_p.z - 0.3) / std::sqrt(2.0)).margin(1e-6));
        ++checked;
    }
    CHECK(checked == 150);
}

TEST_CASE("rsm.paths: a wall hides the patch behind it, the better the finer", "[rsm][paths][VRSM 3.3][analytic]") {
    const raster::Rsm map = wall_map(192);
    // Points before the wall that face it. The lines to the patch pass the wall's plane, within |y| < 1, at 0.57 of their
    // height or, to the patch's far end, at 0.73 of it: none of it is seen from the lower points, a part from the upper.
    Points points(4, 2);
    for (int i = 0; i < 8; ++i) {
        const float z = i < 4 ? 0.1f + 0.12f * float(i) : 1.15f + 0.07f * float(i - 4);
        points.position.texels[i] = glm::vec4(0.6f, 0.3f * noise(i, 5) - 0.15f, z, 0);
        points.normal.texels[i] = glm::vec4(-1, 0, 0, 1);
    }
    const Image4 truth = all_rays(points, map);
    auto sums = [&](const Image4& image, int first) {
        glm::dvec3 sum(0);
        for (int i = first; i < first + 4; ++i) sum += glm::dvec3(image.texels[std::size_t(i)]);
        return sum;
    };
    auto estimate = [&](rsm::Visibility visibility, int directions, int steps, int slots) {
        rsm::GatherParams params = paths_params(visibility, slots);
        params.radius = 0.9f, params.directions = directions, params.steps = steps;
        return gathered(params, points, map);
    };
    CHECK(sums(truth, 0).x == 0);
    CHECK(sums(truth, 4).x > 0);
    const Image4 leaks = estimate(rsm::Visibility::none, 200, 172, 5);
    const Image4 thesis = estimate(rsm::Visibility::algorithm_6, 15, 10, 5);
    const Image4 fine = estimate(rsm::Visibility::algorithm_6, 200, 172, 31);
    for (int first : {0, 4}) {
        const glm::dvec3 t = sums(truth, first), l = sums(leaks, first), c = sums(thesis, first), f = sums(fine, first);
        INFO(fmt::format("{}: red {:.4f} without visibility, {:.4f} 15 x 10 in 5 slots, {:.4f} 200 x 172 in 31, truth "
                         "{:.4f}; green {:.4f} {:.4f} {:.4f} {:.4f}; blue {:.4f} {:.4f} {:.4f} {:.4f}",
                         first == 0 ? "hidden" : "seen in part", l.x, c.x, f.x, t.x, l.y, c.y, f.y, t.y, l.z, c.z, f.z,
                         t.z));
        // What the wall and the floor before it send is not taken away.
        CHECK(f.y == Approx(t.y).epsilon(0.05));
        CHECK(f.z == Approx(t.z).epsilon(0.05));
        CHECK(l.y == Approx(t.y).epsilon(0.05));
    }
    const double leak = sums(leaks, 0).x;
    CHECK(leak > 0.03 * sums(truth, 0).y);
    CHECK(sums(thesis, 0).x < 0.6 * leak);
    CHECK(sums(fine, 0).x < 0.05 * leak);
    CHECK(std::abs(sums(fine, 4).x - sums(truth, 4).x) < 0.25 * std::abs(sums(leaks, 4).x - sums(truth, 4).x));
}

TEST_CASE("rsm.paths: nothing is hidden from a point whose projection is held at the map's border", "[rsm][paths]") {
    // Paths that start elsewhere than the point are no lines of sight. The same wall within the map has some.
    const raster::Rsm map = floor_map(48);
    Points within = wall_points(), beside = within;
    for (glm::vec4& x : beside.position.texels) x.x += 2;
    for (rsm::Texels texels : {rsm::Texels::whole, rsm::Texels::continuous}) {
        rsm::GatherParams hiding = paths_params(rsm::Visibility::algorithm_2), open = hiding;
        open.visibility = rsm::Visibility::none;
        hiding.projection = open.projection = rsm::Projection::clamped;
        hiding.texels = open.texels = texels;
        const Image4 a = gathered(hiding, beside, map), b = gathered(open, beside, map);
        for (std::size_t i = 0; i < a.size(); ++i) {
            CHECK(a.texels[i] == b.texels[i]);
            CHECK(a.texels[i].x > 0);
        }
        CHECK(hidden_share(hiding, beside, map) == 0);
        CHECK(hidden_share(hiding, within, map) > 0.1);
    }
}

// What samples hide is 1 - sight at least: texels from the border over fade map sides, 1 from there on.
TEST_CASE("rsm.paths: towards a clamped map's border less is hidden, by a ramp", "[rsm][paths][analytic]") {
    const raster::Rsm map = floor_map(48);
    const Points points = wall_points();
    for (rsm::Texels texels : {rsm::Texels::whole, rsm::Texels::continuous})
        for (const float fade : {0.0f, 0.125f, 0.5f, 1.0f}) {
            rsm::GatherParams params = paths_params(rsm::Visibility::algorithm_2);
            params.texels = texels, params.fade = fade, params.projection = rsm::Projection::clamped;
            const rsm::Pattern pattern = rsm::pattern_of(params, map.size, 1);
            const rsm::GatherInputs in{&points.position, &points.normal, &map, &pattern, 1};
            int hidden = 0, between = 0;
            for (int i = 0; i < points.position.width; ++i) {
                double x = -1, y = -1, sight = -1;
                for (const TapValue& v : rsm::explain(params, in, {i, 0})) {
                    if (v.name == "centre" || v.name == "texel_of_x") x = double(v.value[0]), y = double(v.value[1]);
                    if (v.name == "sight") sight = double(v.value[0]);
                    if (v.name != "visibility") continue;
                    CHECK((double(v.value[0]) == 1 || double(v.value[0]) == Approx(1 - sight).margin(1e-6)));
                    hidden += double(v.value[0]) < 1;
                }
                REQUIRE((sight >= 0 && sight <= 1));
                between += sight > 0 && sight < 1;
                if (texels == rsm::Texels::continuous) continue;
                const double left = std::min(std::min(x, 47 - x), std::min(y, 47 - y));
                CHECK(sight == Approx(fade == 0 ? double(left > 0) : std::min(1.0, left / (double(fade) * 48))).margin(1e-6));
            }
            CHECK((hidden > 0 && (between > 0) == (fade >= 0.5f)));
        }
}

TEST_CASE("rsm.paths: nothing comes from where there is nothing", "[rsm][paths]") {
    const raster::Rsm floor = floor_map(32);
    for (auto visibility : {rsm::Visibility::none, rsm::Visibility::algorithm_2, rsm::Visibility::algorithm_6}) {
        const rsm::GatherParams params = paths_params(visibility);
        // Empty maps, of one texel and of many.
        for (int size : {1, 16}) {
            raster::Rsm empty = empty_map(size);
            empty.view = floor.view;
            CHECK(black(gathered(params, Points({0, 0, 1}, {0, 0, -1}), empty)));
        }
        // Beyond the reach of the paths on all sides, and at a distance that no index holds.
        for (glm::vec3 x : {glm::vec3(3, 0, 1), {-3, 0, 1}, {0, 3, 1}, {0, -3, 1}, {1e30f, 0, 1}, {0, -3e38f, 1}})
            CHECK(black(gathered(params, Points(x, {0, 0, -1}), floor)));
        // The floor's back.
        CHECK(black(gathered(params, Points({0, 0, -1}, {0, 0, 1}), floor)));
        CHECK_FALSE(black(gathered(params, Points({0, 0, 1}, {0, 0, -1}), floor)));
    }
    // Behind a spot.
    Light spot;
    spot.position = {0, 2, 0}, spot.direction = {0, -1, 0}, spot.cone_outer_deg = 40;
    raster::Rsm lit = empty_map(16);
    lit.view = raster::light_view(spot, {-2, 0, -2}, {2, 4, 2});
    for (int j = 0; j < 16; ++j)
        for (int i = 0; i < 16; ++i) set_texel(lit, i, j, {i / 8.0f - 1, 0, j / 8.0f - 1}, {0, 1, 0}, glm::vec3(1));
    CHECK(black(gathered(paths_params(), Points({0.1f, 3, 0.1f}, {0, -1, 0}), lit)));
    CHECK_FALSE(black(gathered(paths_params(), Points({0.1f, 1, 0.1f}, {0, -1, 0}), lit)));
}

TEST_CASE("rsm.paths: a map of one texel sends as much as the paths' disc covers of it", "[rsm][paths][analytic]") {
    const raster::Rsm one = plane_map(1, [](double, double) { return 1.0; });
    const Points point({0.2f, 0.1f, 1}, {0, 0, -1});
    rsm::GatherParams all;
    all.gather = rsm::Gather::all;
    rsm::GatherParams params = paths_params();
    params.directions = 15, params.steps = 10, params.jitter = 0;
    const double expected = host::pi * 0.3 * 0.3 * gather(all, point, one)(0, 0).x;
    for (auto visibility : {rsm::Visibility::none, rsm::Visibility::algorithm_6}) {
        params.visibility = visibility;
        CHECK(gathered(params, point, one)(0, 0).x == Approx(expected).epsilon(1e-5).margin(0));
    }
    // All samples are the same texel: under Algorithm 2 the first of each path alone is seen, its share the first ring's.
    params.visibility = rsm::Visibility::algorithm_2;
    for (auto [spacing, share] : {std::pair{rsm::Spacing::uniform, 1e-2}, {rsm::Spacing::quadratic, 1e-4}}) {
        params.spacing = spacing;
        CHECK(gathered(params, point, one)(0, 0).x == Approx(expected * share).epsilon(1e-5).margin(0));
    }
}

TEST_CASE("rsm.paths: texels without a surface neither hide nor send light", "[rsm][paths][bits]") {
    // What stands in the positions of every third texel of one map changes no bit, since nothing is there.
    raster::Rsm a = wall_map(64), b = a;
    for (int i = 0; i < 64 * 64; ++i) {
        if (noise(i, 9) > 0.33f) continue;
        for (raster::Rsm* m : {&a, &b}) std::fill_n(m->records.begin() + std::ptrdiff_t(i) * record_stride, 16, 0.0f);
        for (int c = 0; c < 3; ++c) b.records[std::size_t(i) * record_stride + c] = 40 * noise(i, 10 + c) - 20;
    }
    Points points(5, 5);
    for (int i = 0; i < 25; ++i) {
        points.position.texels[i] = glm::vec4(0.6f, noise(i, 1) - 0.5f, 1.2f * noise(i, 2), 0);
        points.normal.texels[i] = glm::vec4(-1, 0, 0, 1);
    }
    for (int slots : {2, 5, 32})
        for (auto visibility : {rsm::Visibility::algorithm_2, rsm::Visibility::algorithm_6}) {
            const Image4 of_a = gathered(paths_params(visibility, slots), points, a);
            const Image4 of_b = gathered(paths_params(visibility, slots), points, b);
            CHECK(std::memcmp(of_a.data(), of_b.data(), of_a.size() * sizeof(glm::vec4)) == 0);
            CHECK_FALSE(black(of_a));
        }
}
