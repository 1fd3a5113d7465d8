// The thickness of samples in the micro linear buffer of rsm.paths: a sample also hides the slots below its own, down to the
// elevation of the point `thickness` below it, away from the light, or as far below it as it is above the plane of x.
#include <catch2/catch.hpp>
#include <fmt/format.h>

#include <cstring>

#include "core/hash.h"
#include "gi/rsm/paths_kernel.h"
#include "path_reference.h"
#include "rsm_scenes.h"

using namespace plumb;
using namespace plumb::test;

namespace {

constexpr float endless = 1e9f;

rsm::GatherParams with(float thickness, int slots = 5, rsm::Visibility visibility = rsm::Visibility::algorithm_6) {
    rsm::GatherParams params;
    params.gather = rsm::Gather::paths;
    params.thickness = thickness, params.slots = slots, params.visibility = visibility;
    return params;
}

constexpr double up[3] = {0, 0, 1};
const glm::vec3 facing_the_path(1, 0, 0);

// The kernel's visibilities of samples along a path, seen from x of the normal n, under a light along `axis`.
std::vector<float> seen(const rsm::GatherParams& params, const std::vector<glm::vec3>& path, const glm::vec3& n = facing_the_path,
                        const double (&axis)[3] = up) {
    const Buffer<float> edges = rsm::slot_edges(params);
    rsm::PathsInputsView<float> in{};
    for (int c = 0; c < 3; ++c) in.u.axis[c] = float(axis[c]);
    in.u.slots = params.slots, in.u.thickness = params.thickness;
    in.u.propagates = params.visibility == rsm::Visibility::algorithm_2 ? 0 : -1;
    in.edges = edges.data();
    rsm::MicroLinearBuffer<float> met{-1, 0, 0};
    NoTap tap;
    std::vector<float> result;
    for (const glm::vec3& d : path)
        result.push_back(rsm::visibility_of<float>(in, {d.x, d.y, d.z}, {n.x, n.y, n.z}, true, met, tap));
    return result;
}

double radians(double degrees) { return degrees * host::pi / 180; }

// A sample at `distance` from x, `height` above it.
glm::vec3 at(double distance, double height) { return {float(distance), 0, float(height)}; }
// One that is seen under an elevation of so many degrees.
glm::vec3 under(double degrees, double distance) {
    return at(distance * std::cos(radians(degrees)), distance * std::sin(radians(degrees)));
}

// Algorithms 2 and 3 of a buffer in which a sample takes the slots [lowest, idx], by angles and flags.
struct ThickBuffer {
    std::vector<bool> occluded;
    bool repeats;
    int idx_before = -1;
    float v_before = 0;
    ThickBuffer(int slots, bool repeats) : occluded(std::size_t(slots), false), repeats(repeats) {}
    float visibility(int idx, int lowest) {
        float v = v_before;
        if (!repeats || idx != idx_before) v = occluded[std::size_t(idx)] ? 0 : 1;
        for (int i = lowest; i <= idx; ++i) occluded[std::size_t(i)] = true;
        idx_before = idx, v_before = v;
        return v;
    }
};

// Numbers of [0, 1).
struct Stream {
    std::int32_t path, next = 0;
    double operator()() { return unit_float<float>(pixel_hash<std::int32_t>(path, next++, 0, 53).x); }
    double between(double a, double b) { return a + (b - a) * operator()(); }
};

// Whether phi lies within rounding of where two slots meet.
bool on_edge(double phi, int slots) {
    const double place = (phi / host::pi + 0.5) * slots;
    return std::abs(place - std::round(place)) < 1e-4;
}

// A sun straight above a floor, of which a block before x is so high that x sees nothing of what lies behind it: the map's
// middle is below x = (0, 0, 1). The block's top, at x in [0.5, 0.7], is `top` above x; behind it a patch at the height of x
// alone sends light.
raster::Rsm block_map(int size, double top) {
    raster::Rsm map = plane_map(size, [](double, double) { return 0.0; });
    for (int j = 0; j < size; ++j)
        for (int i = 0; i < size; ++i) {
            const float x = (2 * float(i) + 1) / float(size) - 1, y = 1 - (2 * float(j) + 1) / float(size);
            if (x > 0.5f && x < 0.7f) set_texel(map, i, j, {x, y, float(1 + top)}, {0, 0, 1}, glm::vec3(0));
            if (x > 0.85f && x < 0.95f && std::abs(y) < 0.25f) set_texel(map, i, j, {x, y, 1}, {-1, 0, 0}, glm::vec3(1));
        }
    return map;
}

rsm::GatherParams fine(float thickness) {
    rsm::GatherParams params = with(thickness);
    params.directions = 60, params.steps = 24, params.spacing = rsm::Spacing::uniform, params.radius = 0.6f;
    return params;
}

Image4 gathered(const rsm::GatherParams& params, const Points& points, const raster::Rsm& map) {
    const rsm::Pattern pattern = rsm::pattern_of(params, map.size, 1);
    return gather(params, points, map, &pattern);
}

bool same_bits(const Image4& a, const Image4& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(glm::vec4)) == 0;
}

}  // namespace

TEST_CASE("rsm.paths: what a thick sample hides is what its angles say", "[rsm][paths][thickness]") {
    constexpr int steps = 10;
    std::int64_t samples = 0, skipped = 0, wrong = 0, more = 0;
    for (int number = 0; number < 40000; ++number) {
        Stream random{number};
        const int slots = 2 + number % 31;
        const double unit = std::exp(random.between(-8, 8)), thickness = unit * std::exp(random.between(-5, 4));
        std::vector<glm::vec3> path;
        std::vector<int> idx, lowest;
        const double turn = random.between(-host::pi, host::pi);
        const glm::vec3 n = at(std::cos(turn), std::sin(turn));
        bool clear = true;
        for (int k = 0; k < steps; ++k) {
            const double phi = random.between(-host::pi / 2, host::pi / 2), far = unit * (k + 0.5);
            const glm::vec3 d = at(far * std::cos(phi), far * std::sin(phi));
            path.push_back(d);
            const double over = double(n.x) * d.x + double(n.z) * d.z, depth = std::max(0.0, std::min(thickness, over));
            const double own = elevation({d.x, d.y, d.z}, up), low = elevation({d.x, d.y, d.z - depth}, up);
            idx.push_back(slot_by_angle(own, slots)), lowest.push_back(slot_by_angle(low, slots));
            // What ends beside x has no elevation to speak of.
            clear = clear && !on_edge(own, slots) && !on_edge(low, slots) && std::hypot(d.x, d.z - depth) > 0.02 * far;
        }
        samples += steps;
        if (!clear) {
            skipped += steps;
            continue;
        }
        for (auto visibility : {rsm::Visibility::algorithm_2, rsm::Visibility::algorithm_3, rsm::Visibility::algorithm_6}) {
            const bool repeats = visibility != rsm::Visibility::algorithm_2;
            const std::vector<float> thick = seen(with(float(thickness), slots, visibility), path, n);
            const std::vector<float> thin = seen(with(0, slots, visibility), path, n);
            ThickBuffer expected(slots, repeats);
            for (std::size_t k = 0; k < steps; ++k) {
                wrong += thick[k] != expected.visibility(idx[k], lowest[k]);
                more += thick[k] != thin[k];
            }
        }
    }
    INFO(fmt::format("{} samples, {} of paths with one on an edge; {} hidden by the thickness alone", samples, skipped, more));
    CHECK(wrong == 0);
    CHECK(skipped < samples / 10);
    CHECK(more > samples / 20);
}

TEST_CASE("rsm.paths: a sample of thickness 0 takes its slot alone, an endless one all down to the plane of x",
          "[rsm][paths][thickness][analytic]") {
    // x faces the light: its plane lies at elevation 0, and nothing below it sends light to x.
    for (int slots : {2, 5, 9, 31, 32})
        for (auto visibility : {rsm::Visibility::algorithm_2, rsm::Visibility::algorithm_3, rsm::Visibility::algorithm_6})
            for (int first = 0; first < slots; ++first)
                for (int then = 0; then < slots; ++then) {
                    if (first == then) continue;
                    CAPTURE(slots, first, then);
                    const auto middle = [&](int slot) { return 180 * ((slot + 0.5) / slots - 0.5); };
                    const std::vector<glm::vec3> path = {under(middle(first), 1), under(middle(then), 2)};
                    CHECK(seen(with(0, slots, visibility), path, at(0, 1))[1] == 1);
                    const bool hidden = then < first && then >= slots / 2;
                    CHECK(seen(with(endless, slots, visibility), path, at(0, 1))[1] == (hidden ? 0 : 1));
                }
}

TEST_CASE("rsm.paths: a wall hides what lies behind it from its top down to its foot", "[rsm][paths][thickness][analytic]") {
    // Five slots meet at -54, -18, 18 and 54 degrees. The wall's top lies 0.3 m above x, 0.6 m away, under 26.6 degrees; slot 2,
    // of -18 to 18 degrees, is reached from there at a depth of 0.3 - 0.6 tan 18, slot 1 at 0.3 + 0.6 tan 18. The plane of x is
    // 0.6 m away: the wall is no deeper than that.
    const double depth = 0.3 - 0.6 * std::tan(radians(18)), lower = 0.3 + 0.6 * std::tan(radians(18));
    const std::vector<glm::vec3> wall_then_patch = {at(0.6, 0.3), at(2, 0)};
    const std::vector<glm::vec3> wall_then_lower = {at(0.6, 0.3), under(-36, 2)}, wall_then_foot = {at(0.6, 0.3), under(-72, 2)};
    for (auto visibility : {rsm::Visibility::algorithm_2, rsm::Visibility::algorithm_6}) {
        const auto second = [&](double thickness, const std::vector<glm::vec3>& path) {
            return seen(with(float(thickness), 5, visibility), path)[1];
        };
        CHECK(second(0, wall_then_patch) == 1);  // leaks: slot 3 alone is taken
        CHECK(second(depth - 1e-4, wall_then_patch) == 1);
        CHECK(second(depth + 1e-4, wall_then_patch) == 0);
        CHECK(second(depth + 1e-4, wall_then_lower) == 1);
        CHECK(second(lower - 1e-4, wall_then_lower) == 1);
        CHECK(second(lower + 1e-4, wall_then_lower) == 0);
        CHECK(second(endless, wall_then_lower) == 0);
        CHECK(second(endless, wall_then_foot) == 1);
        // What is above the wall is seen over it, however thick it is.
        CHECK(second(endless, {at(0.6, 0.3), under(60, 2)}) == 1);
    }
}

TEST_CASE("rsm.paths: a thin bar that floats hides its own slot alone", "[rsm][paths][thickness][analytic]") {
    // In the middle of a slot, 2 m away: its lower edge, 18 degrees farther down, is more than 0.6 m below it.
    for (double slot : {-72, -36, 0, 36, 72})
        for (double other : {-72, -36, 0, 36, 72}) {
            CAPTURE(slot, other);
            if (other == slot) continue;
            const std::vector<float> v = seen(with(0.02f), {under(slot, 2), under(other, 3), under(slot, 4)});
            CHECK(v[1] == 1);
            CHECK(v[2] == 0);  // its own slot is taken, once something else was met in between
        }
}

TEST_CASE("rsm.paths: thickness is measured along the light's axis, in metres", "[rsm][paths][thickness][analytic]") {
    // Everything turned, the axis with it, and the same path ten times as large with ten times the thickness.
    const double depth = 0.3 - 0.6 * std::tan(radians(18)), axis[3] = {0.6, 0, 0.8};
    const auto turned = [&](const glm::vec3& d) { return glm::vec3(0.8f * d.x + 0.6f * d.z, 0, -0.6f * d.x + 0.8f * d.z); };
    for (double scale : {1.0, 10.0, 1000.0})
        for (double side : {-1e-3, 1e-3}) {
            const float thickness = float(scale * (depth + side));
            const glm::vec3 wall = at(0.6 * scale, 0.3 * scale), patch = at(2 * scale, 0);
            CHECK(seen(with(thickness), {wall, patch})[1] == (side < 0 ? 1 : 0));
            CHECK(seen(with(thickness), {turned(wall), turned(patch)}, turned(facing_the_path), axis)[1] == (side < 0 ? 1 : 0));
        }
    // A wall twice as far with the same thickness reaches half as low.
    CHECK(seen(with(float(depth + 1e-3)), {at(1.2, 0.6), at(4, 0)})[1] == 1);
}

TEST_CASE("rsm.paths: light behind a block leaks without a thickness and not with one", "[rsm][paths][thickness][analytic]") {
    // The block stands on the floor and rises 0.3 m above x: every line to the patch, which lies as high as x, meets it. Seen
    // from x its top lies in slot 3 (18 to 54 degrees), the patch in slot 2. On paths to the patch the top is 0.5 to 0.74 m
    // away: a thickness of 0.05 stays in slot 3 (0.25 / 0.74 > tan 18), one of 0.2 reaches slot 2 (0.1 / 0.5 < tan 18).
    const raster::Rsm map = block_map(128, 0.3);
    const Points x({0, 0, 1}, {1, 0, 0});
    const float leak = gathered(fine(0), x, map)(0, 0).x;
    rsm::GatherParams none = fine(0);
    none.visibility = rsm::Visibility::none;
    CHECK(leak > 0);
    CHECK(leak == gathered(none, x, map)(0, 0).x);
    CHECK(gathered(fine(0.05f), x, map)(0, 0).x == leak);
    for (float thickness : {0.2f, 1.3f, endless}) CHECK(gathered(fine(thickness), x, map)(0, 0).x == 0);
    // A block that ends below the lines hides nothing from them: 0.6 m below x its top lies in slot 1 or 0.
    for (float thickness : {0.0f, 0.2f, endless}) {
        const raster::Rsm low = block_map(128, -0.6);
        CHECK(gathered(fine(thickness), x, low)(0, 0).x == gathered(none, x, low)(0, 0).x);
    }
    // Without visibility a thickness says nothing.
    none.thickness = endless;
    CHECK(gathered(none, x, map)(0, 0).x == leak);
}

TEST_CASE("rsm.paths: a floor hides nothing of itself, whatever its thickness", "[rsm][paths][thickness][analytic]") {
    // Its elevation rises along each path, from a wall, and stays where it is, from the floor: only what lies below is hidden.
    const raster::Rsm map = plane_map(256, [](double x, double y) { return 1 + 0.5 * x - 0.2 * y; });
    Points points(4, 4);
    for (int i = 0; i < 16; ++i) {
        points.position.texels[i] = glm::vec4(0.3f, 0.1f * float(i % 4), 0.1f * float(i / 4), 0);
        points.normal.texels[i] = i < 4 ? glm::vec4(0, 0, 1, 1) : glm::vec4(-1, 0, 0, 1);
    }
    rsm::GatherParams none = with(0);
    none.visibility = rsm::Visibility::none, none.jitter = 0;
    const Image4 whole = gathered(none, points, map);
    for (float thickness : {0.0f, 0.1f, 1.0f, endless}) {
        rsm::GatherParams params = with(thickness);
        params.jitter = 0;
        CHECK(same_bits(gathered(params, points, map), whole));
    }
}

TEST_CASE("rsm.paths: a texel without a surface has no thickness", "[rsm][paths][thickness]") {
    // It stands above the patch, but nothing is there.
    const rsm::GatherParams params = with(endless);
    const Buffer<float> edges = rsm::slot_edges(params);
    for (int propagates : {-1, 0}) {
        rsm::PathsInputsView<float> in{};
        in.u.axis[2] = 1, in.u.slots = params.slots, in.u.thickness = endless, in.u.propagates = propagates;
        in.edges = edges.data();
        for (bool surface : {false, true}) {
            rsm::MicroLinearBuffer<float> met{-1, 0, 0};
            NoTap tap;
            rsm::visibility_of<float>(in, {0.5f, 0, 0.5f}, {1, 0, 0}, surface, met, tap);
            CHECK(rsm::visibility_of<float>(in, {2, 0, 0}, {1, 0, 0}, true, met, tap) == (surface ? 0 : 1));
        }
    }
}

TEST_CASE("rsm.paths: what lies in the plane of x or behind it has no thickness", "[rsm][paths][thickness][analytic]") {
    // The wall that x is on, above x: beside a texel's middle the first sample of a path may lie anywhere on it.
    for (const glm::vec3& own : {glm::vec3(0, 0.01f, 0.02f), {-0.01f, 0, 0.02f}, {-1, 0, 1}})
        for (double degrees : {-72, -36, 0})
            CHECK(seen(with(endless), {own, under(degrees, 1)}) == std::vector<float>{1, 1});
    // A little before it it reaches no farther than that.
    CHECK(seen(with(endless), {at(1e-3, 0.1), under(0, 1)})[1] == 1);
}
