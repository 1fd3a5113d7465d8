// The micro linear buffer of rsm.paths against VRSM's algorithms as printed.
#include <catch2/catch.hpp>
#include <fmt/format.h>

#include "core/hash.h"
#include "gi/rsm/paths_kernel.h"
#include "path_reference.h"
#include "rsm_scenes.h"

using namespace plumb;
using namespace plumb::test;

namespace {

constexpr int steps = 10;
constexpr vec3<float> n{0, 0, 1};  // of x: read where a sample has a thickness

// Numbers of [0, 1).
struct Stream {
    std::int32_t path, next = 0;
    double operator()() {
        return unit_float<float>(pixel_hash<std::int32_t>(path, next++, 0, 41).x);
    }
    double between(double a, double b) { return a + (b - a) * operator()(); }
};

// A path: the vectors from x to its samples, in floats, with the axis that elevation is measured along.
struct Path {
    float axis[3];
    vec3<float> d[steps];
};

// An axis of any direction. Half of the paths jump between elevations, half run along a surface whose elevation drifts,
// as maps have it; distances are of any size.
Path random_path(int number) {
    Stream random{number};
    const double z = random.between(-1, 1), turn = random.between(0, 2 * host::pi), across = std::sqrt(1 - z * z);
    const double axis[3] = {across * std::cos(turn), across * std::sin(turn), z};
    // Two more axes, and the direction of the path between them.
    const double up[3] = {std::abs(z) < 0.5 ? 0.0 : 1.0, 0, std::abs(z) < 0.5 ? 1.0 : 0.0};
    double u[3], v[3], length = 0;
    for (int c = 0; c < 3; ++c) u[c] = up[c] - (up[0] * axis[0] + up[1] * axis[1] + up[2] * axis[2]) * axis[c];
    for (double c : u) length += c * c;
    for (double& c : u) c /= std::sqrt(length);
    for (int c = 0; c < 3; ++c) v[c] = axis[(c + 1) % 3] * u[(c + 2) % 3] - axis[(c + 2) % 3] * u[(c + 1) % 3];
    const double a = random.between(0, 2 * host::pi), ca = std::cos(a), sa = std::sin(a);

    Path p;
    for (int c = 0; c < 3; ++c) p.axis[c] = float(axis[c]);
    const bool jumps = number % 2 == 0;
    double phi = random.between(-host::pi / 2, host::pi / 2);
    const double unit = std::exp(random.between(-12, 12));
    for (int k = 0; k < steps; ++k) {
        phi = jumps ? random.between(-host::pi / 2, host::pi / 2)
                    : std::clamp(phi + random.between(-0.3, 0.3), -host::pi / 2, host::pi / 2);
        const double far = unit * (k + 0.5), out = std::cos(phi), high = std::sin(phi);
        float d[3];
        for (int c = 0; c < 3; ++c) d[c] = float(far * (out * (ca * u[c] + sa * v[c]) + high * axis[c]));
        p.d[k] = {d[0], d[1], d[2]};
    }
    return p;
}

// Records which slot the kernel chose.
struct SlotTap : NoTap {
    std::int32_t slot = -1;
    using NoTap::operator();
    void operator()(const char* name, std::int32_t v, const char* = "") {
        if (std::string_view(name) == "slot") slot = v;
    }
};

rsm::GatherParams with(int slots, rsm::SlotEdges edges, rsm::Visibility visibility = rsm::Visibility::algorithm_6) {
    rsm::GatherParams params;
    params.gather = rsm::Gather::paths;
    params.slots = slots;
    params.slot_edges = edges;
    params.visibility = visibility;
    return params;
}

// The kernel's slots and visibilities along a path.
struct Met {
    int slot[steps];
    float visibility[steps];
};
Met kernel_along(const Path& p, const rsm::GatherParams& params, const Buffer<float>& edges) {
    rsm::PathsInputsView<float> in{};
    for (int c = 0; c < 3; ++c) in.u.axis[c] = p.axis[c];
    in.u.slots = params.slots;
    in.u.propagates = params.visibility == rsm::Visibility::algorithm_2 ? 0 : -1;
    in.edges = edges.data();
    rsm::MicroLinearBuffer<float> met{-1, 0, 0};
    Met result;
    for (int k = 0; k < steps; ++k) {
        SlotTap tap;
        result.visibility[k] = rsm::visibility_of<float>(in, p.d[k], n, true, met, tap);
        result.slot[k] = tap.slot;
    }
    return result;
}

// Whether d lies so near to the edge between two slots that rounding may put it on either side. With sigma the sine of
// the elevation and s the edge's, the kernel compares sigma |sigma| with s |s|, each times d^2: dz is off by at most
// 4 u |d| (three products, two sums, and the axis), dz |dz| by twice |sigma| that and a rounding, d^2 by 4 u, s |s| and their
// product by u each; u = 2^-24.
bool on_edge(double sigma, double s) {
    const double u = 0x1p-24, difference = std::abs(sigma * std::abs(sigma) - s * std::abs(s));
    return difference <= u * (std::abs(sigma) * (8 + std::abs(sigma)) + 6 * s * s) + 16 * u * u;
}

}  // namespace

TEST_CASE("rsm.paths: edges of slots are s |s|", "[rsm][paths][VRSM 3.3][analytic]") {
    // sin 54 and sin 18 degrees, squared: (3 + sqrt 5) / 8 and (3 - sqrt 5) / 8.
    const double far = (3 + std::sqrt(5.0)) / 8, near = (3 - std::sqrt(5.0)) / 8;
    const Buffer<float> angle = rsm::slot_edges(with(5, rsm::SlotEdges::angle));
    REQUIRE(angle.size() == 4);
    const double of_angle[] = {-far, -near, near, far}, of_solid[] = {-0.36, -0.04, 0.04, 0.36};
    const Buffer<float> solid = rsm::slot_edges(with(5, rsm::SlotEdges::solid_angle));
    REQUIRE(solid.size() == 4);
    for (std::size_t i = 0; i < 4; ++i) {
        CHECK(angle[i] == Approx(of_angle[i]).epsilon(1e-7).margin(0));
        CHECK(solid[i] == Approx(of_solid[i]).epsilon(1e-7).margin(0));
    }
    // An even number of slots has an edge at elevation 0, to the bit.
    for (int slots : {2, 4, 6, 16, 32})
        for (auto kind : {rsm::SlotEdges::angle, rsm::SlotEdges::solid_angle})
            CHECK(rsm::slot_edges(with(slots, kind))[std::size_t(slots / 2 - 1)] == 0);
    for (int slots = 2; slots <= 32; ++slots)
        for (auto kind : {rsm::SlotEdges::angle, rsm::SlotEdges::solid_angle}) {
            const Buffer<float> edges = rsm::slot_edges(with(slots, kind));
            REQUIRE(edges.size() == std::size_t(slots - 1));
            CHECK(std::is_sorted(edges.begin(), edges.end()));
            CHECK((edges.front() > -1 && edges.back() < 1));
        }
}

TEST_CASE("rsm.paths: visibility is that of Algorithms 2, 3 and 6 as printed", "[rsm][paths][VRSM 3.3]") {
    // 100,000 paths of 10 samples; each meets every number of slots and both kinds of edges.
    constexpr int paths = 100000;
    std::int64_t samples = 0, apart = 0, hidden = 0, seen = 0, unexplained = 0, wrong = 0;
    std::vector<Buffer<float>> edges[2];
    for (int slots = 0; slots <= 32; ++slots)
        for (int kind = 0; kind < 2; ++kind)
            edges[kind].push_back(slots < 2 ? Buffer<float>() : rsm::slot_edges(with(slots, rsm::SlotEdges(kind))));
    for (int number = 0; number < paths; ++number) {
        const Path p = random_path(number);
        double axis[3], length = 0, phi[steps];
        for (float c : p.axis) length += double(c) * c;
        for (int c = 0; c < 3; ++c) axis[c] = p.axis[c] / std::sqrt(length);
        for (int k = 0; k < steps; ++k) phi[k] = elevation({p.d[k].x, p.d[k].y, p.d[k].z}, axis);
        // Two numbers of slots a path: every number is met by 6,400 paths or more.
        for (int slots : {2 + number % 31, 2 + number / 31 % 31})
            for (int kind = 0; kind < 2; ++kind) {
                int idx[steps];
                for (int k = 0; k < steps; ++k)
                    idx[k] = kind == 0 ? slot_by_angle(phi[k], slots) : slot_by_solid_angle(phi[k], slots);
                for (auto visibility : {rsm::Visibility::algorithm_2, rsm::Visibility::algorithm_3,
                                        rsm::Visibility::algorithm_6}) {
                    const rsm::GatherParams params = with(slots, rsm::SlotEdges(kind), visibility);
                    const Met met = kernel_along(p, params, edges[kind][std::size_t(slots)]);
                    bool same_slots = true;
                    for (int k = 0; k < steps; ++k) {
                        ++samples;
                        if (met.slot[k] == idx[k]) continue;
                        same_slots = false, ++apart;
                        const double share = double(std::max(met.slot[k], idx[k])) / slots;
                        const double s = kind == 0 ? std::sin(host::pi * (share - 0.5)) : 2 * share - 1;
                        unexplained += std::abs(met.slot[k] - idx[k]) != 1 || !on_edge(std::sin(phi[k]), s);
                    }
                    if (!same_slots) continue;
                    Algorithm2 two(slots);
                    Algorithm3 three(slots);
                    Algorithm6 six(slots);
                    for (int k = 0; k < steps; ++k) {
                        const double by2 = two.visibility(idx[k]), by3 = three.visibility(idx[k]),
                                     by6 = six.visibility(idx[k]);
                        const double expected = visibility == rsm::Visibility::algorithm_2   ? by2
                                                : visibility == rsm::Visibility::algorithm_3 ? by3
                                                                                             : by6;
                        wrong += met.visibility[k] != expected || by3 != by6;
                        met.visibility[k] == 0 ? ++hidden : ++seen;
                    }
                }
            }
    }
    INFO(fmt::format("{} samples, {} in another slot, {} of them not on an edge", samples, apart, unexplained));
    CHECK(samples == 12LL * paths * steps);
    CHECK(wrong == 0);
    CHECK(unexplained == 0);
    CHECK(double(apart) < 1e-4 * double(samples));
    CHECK((hidden > samples / 100 && seen > samples / 100));
}

TEST_CASE("rsm.paths: a sample on an edge belongs to the upper slot", "[rsm][paths][VRSM 3.3]") {
    // Elevation 0 with an even number of slots, straight up and straight down, and what has no direction.
    Path p{};
    p.axis[1] = 1;
    p.d[0] = {1, 0, 0}, p.d[1] = {0, 1, 0}, p.d[2] = {0, -1, 0}, p.d[3] = {0, 0, 0}, p.d[4] = {1, -1e-6f, 0};
    for (int slots : {2, 4, 5, 32}) {
        const rsm::GatherParams params = with(slots, rsm::SlotEdges::angle);
        const Met met = kernel_along(p, params, rsm::slot_edges(params));
        CAPTURE(slots);
        CHECK(met.slot[0] == slots / 2);
        CHECK(met.slot[1] == slots - 1);
        CHECK(met.slot[2] == 0);
        CHECK(met.slot[3] == slots - 1);  // 0 >= s |s| 0 throughout
        CHECK(met.slot[4] == (slots % 2 == 0 ? slots / 2 - 1 : slots / 2));
    }
}

TEST_CASE("rsm.paths: a texel without a surface changes nothing for those after it", "[rsm][paths][VRSM 3.3]") {
    // The visibilities of what has a surface are those of the path without the rest.
    int holes = 0;
    for (int number = 0; number < 4000; ++number) {
        const Path p = random_path(number);
        Stream random{-1 - number};
        const int slots = 2 + number % 31;
        for (auto visibility : {rsm::Visibility::algorithm_2, rsm::Visibility::algorithm_6}) {
            const rsm::GatherParams params = with(slots, rsm::SlotEdges::angle, visibility);
            const Buffer<float> edges = rsm::slot_edges(params);
            rsm::PathsInputsView<float> in{};
            for (int c = 0; c < 3; ++c) in.u.axis[c] = p.axis[c];
            in.u.slots = slots, in.u.propagates = visibility == rsm::Visibility::algorithm_2 ? 0 : -1;
            in.edges = edges.data();
            rsm::MicroLinearBuffer<float> with_holes{-1, 0, 0}, without{-1, 0, 0};
            NoTap tap;
            for (int k = 0; k < steps; ++k) {
                const bool surface = random() < 0.6;
                const float v = rsm::visibility_of<float>(in, p.d[k], n, surface, with_holes, tap);
                if (surface) CHECK(v == rsm::visibility_of<float>(in, p.d[k], n, true, without, tap));
                holes += !surface;
            }
        }
    }
    CHECK(holes > 10000);
}
