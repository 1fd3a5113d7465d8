// Kernel density, thinning, the radius of probes, and who supports whom.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "core/error.h"
#include "core/hash.h"
#include "gi/probes/density.h"
#include "gi/probes/placement.h"
#include "gi/probes/supports.h"
#include "gi/probes/thinning.h"

using namespace plumb;
using namespace plumb::probes;

namespace {

using Points = Buffer<glm::vec4>;

float noise(int i, int seed) { return float(pcg(std::uint32_t(i + 7919 * seed)) & 0xffffff) / 16777216.0f; }

Points scattered(int n, int seed) {
    Points p;
    for (int i = 0; i < n; ++i) p.push_back({noise(3 * i, seed), noise(3 * i + 1, seed), noise(3 * i + 2, seed), 0});
    return p;
}
Points lattice(int nx, int ny, int nz) {
    Points p;
    for (int z = 0; z < nz; ++z)
        for (int y = 0; y < ny; ++y)
            for (int x = 0; x < nx; ++x) p.push_back({x, y, z, 0});
    return p;
}

// As it is printed.
double printed_weight(double t) { return t <= 1 ? 2 * t * t * t - 3 * t * t + 1 : 0; }

Buffer<float> density_of(const Points& points, float radius, const RunOptions& options = {}) {
    Buffer<float> density;
    run(DensityInputs{&points, radius}, options, density);
    return density;
}

template <class Body>
void for_all_options(Body body) {
    for (Isa isa : supported_isas())
        for (int threads : {1, 2, 3}) {
            RunOptions options;
            options.isa = isa, options.threads = threads;
            CAPTURE(isa_name(isa), threads);
            body(options);
        }
}

using Indices = std::vector<std::int32_t>;

// The plain form of thinning: of all that are left the densest, looked for anew each time.
Indices plainly_thinned(const Points& points, float radius, int wanted) {
    const Buffer<float> initial = density_of(points, radius);
    std::vector<std::int64_t> density;
    const auto fixed = [](float x) { return std::int64_t(std::floor(double(x) * 0x1p32 + 0.5)); };
    for (const float k : initial) density.push_back(fixed(k));
    Indices left;
    for (int i = 0; i < int(points.size()); ++i) left.push_back(i);
    while (int(left.size()) > wanted) {
        auto densest = left.begin();
        const auto steps = [&](std::int32_t i) { return (density[std::size_t(i)] + (1 << 19)) >> 20; };
        for (auto i = left.begin(); i != left.end(); ++i)
            if (steps(*i) > steps(*densest)) densest = i;
        const std::int32_t gone = *densest;
        left.erase(densest);
        for (const std::int32_t i : left) {
            const glm::vec3 p(points[std::size_t(i)]), q(points[std::size_t(gone)]);
            const float t = std::sqrt(distance2<float>(p, q)) * (1 / radius);
            if (t < 1) density[std::size_t(i)] -= fixed(spatial_weight<float>(t));
        }
    }
    return left;
}

}  // namespace

// Expected: of a lattice with spacing 1 and radius 2: 6 neighbours at 1, w(1/2) = 1/2; 12 at sqrt(2), w(0.7071) = 0.207107;
// 8 at sqrt(3), w(0.8660) = 0.049038; those at 2 weigh 0: K = 3 + 2.485281 + 0.392305. A corner has 3, 3 and 1 of them.
TEST_CASE("probes.density: a lattice in closed form", "[probes][IPR 3.2.2.1]") {
    const Buffer<float> k = density_of(lattice(7, 7, 7), 2);
    CHECK(k[3 * 49 + 3 * 7 + 3] == Approx(5.877586).epsilon(1e-6));
    CHECK(k[0] == Approx(1.5 + 3 * 0.2071068 + 0.0490381).epsilon(1e-6));
    // Another radius, against the sum over offsets as printed.
    double sum = 0;
    for (int x = -3; x <= 3; ++x)
        for (int y = -3; y <= 3; ++y)
            for (int z = -3; z <= 3; ++z)
                if (x || y || z) sum += printed_weight(std::sqrt(double(x * x + y * y + z * z)) / 3.3);
    CHECK(density_of(lattice(7, 7, 7), 3.3f)[3 * 49 + 3 * 7 + 3] == Approx(sum).epsilon(1e-6));
    CHECK(density_of(lattice(1, 1, 1), 1) == Buffer<float>{0.0f});
    // Points in one place weigh 1.
    CHECK(density_of(Points(3, glm::vec4(5)), 1) == Buffer<float>(3, 2.0f));
}

TEST_CASE("probes.density: the same bits for every instruction set and thread count, and as the plain sum",
          "[probes][bits]") {
    // Sorted as voxels are, so that far blocks are left out; more than a row of the fold.
    Points points = scattered(2500, 1);
    std::sort(points.begin(), points.end(), [](const glm::vec4& a, const glm::vec4& b) { return a.z < b.z; });
    const StageData data = data_of(DensityInputs{&points, 0.1f});
    const auto bound = stage<DensityKernel>().bind(data);
    const Buffer<float> first = density_of(points, 0.1f);
    for (int i = 0; i < 2500; i += 7) {
        const std::vector<TapValue> told = bound->explain({i % data.size.x, i / data.size.x});  // asks all others
        REQUIRE(told.back().name == "density");
        CHECK(float(told.back().value[0]) == first[std::size_t(i)]);
        CHECK(first[std::size_t(i)] > 0);
    }
    for_all_options([&](const RunOptions& options) { CHECK(density_of(points, 0.1f, options) == first); });
}

// Expected by hand: spacing 1, radius 3/2: w(2/3) = 7/27 from each neighbour, so that all but the ends are equally dense.
// The first of them goes, index 1; its neighbours fall to 0 and 7/27; then 3, 5, ...: every second point is left, and no
// one has a neighbour. With twice the radius the same happens to those.
TEST_CASE("probes: a line of points is thinned evenly", "[probes][IPR 3.2.2.1]") {
    const Points line = lattice(17, 1, 1);
    CHECK(density_of(line, 1.5f)[5] == Approx(14.0 / 27));
    CHECK(thin(line, 1.5f, 16, {}).kept == Indices{0, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16});
    const Thinned half = thin(line, 1.5f, 9, {});
    CHECK(half.kept == Indices{0, 2, 4, 6, 8, 10, 12, 14, 16});
    CHECK(half.doublings == 0);
    const Thinned quarter = thin(line, 1.5f, 5, {});
    CHECK(quarter.kept == Indices{0, 4, 8, 12, 16});
    CHECK(quarter.doublings == 1);
    CHECK(quarter.radius == 3);
    CHECK(thin(line, 1.5f, 1, {}).kept.size() == 1);
    CHECK(thin(line, 1.5f, 17, {}).kept.size() == 17);
}

TEST_CASE("probes: thinning is the plain form's, and every step takes the densest", "[probes][IPR 3.2.2.1]") {
    for (const int seed : {1, 2, 3}) {
        Points points = scattered(300, seed);
        if (seed == 3)
            for (glm::vec4& p : points) p = glm::floor(p * 9.0f);  // a lattice, with several in one place
        const float radius = seed == 3 ? 3.5f : 0.4f;
        for (const int wanted : {299, 150, 40}) {
            CAPTURE(seed, wanted);
            const Thinned t = thin(points, radius, wanted, {});
            CHECK(t.doublings == 0);
            CHECK(t.kept == plainly_thinned(points, radius, wanted));
        }
        // From scratch in double: who went was the densest, but for the steps of 2^-12 and float's rounding.
        Indices before = thin(points, radius, 200, {}).kept;
        for (int wanted = 199; wanted > 190; --wanted) {
            const Indices after = thin(points, radius, wanted, {}).kept;
            double most = 0, gone = -1;
            for (const std::int32_t i : before) {
                double k = 0;
                for (const std::int32_t j : before)
                    if (i != j) {
                        const glm::dvec3 p(points[std::size_t(i)]), q(points[std::size_t(j)]);
                        k += printed_weight(glm::length(p - q) / radius);
                    }
                most = std::max(most, k);
                if (!std::binary_search(after.begin(), after.end(), i)) gone = k;
            }
            CHECK(gone >= most - 0x1p-11);
            before = after;
        }
    }
}

// Expected: what is left is spread more evenly than chance: of 100 in the unit cube the nearest two are about 0.01 apart
// where they are drawn at random, 0.15 on a cubic lattice with half its spacing to spare.
TEST_CASE("probes: what is left after thinning is evenly spread", "[probes][figure 3.14]") {
    const auto least = [](const Points& p, const Indices& of) {
        double d = 1e9;
        for (const std::int32_t i : of)
            for (const std::int32_t j : of)
                if (i < j) d = std::min(d, glm::length(glm::dvec3(p[std::size_t(i)]) - glm::dvec3(p[std::size_t(j)])));
        return d;
    };
    const Points points = scattered(5000, 4);
    const Thinned t = thin(points, 0.215f, 100, {});  // 100^(-1/3)
    REQUIRE(t.kept.size() == 100);
    Indices first(100);
    for (int i = 0; i < 100; ++i) first[std::size_t(i)] = i;
    CHECK(least(points, first) < 0.05);
    CHECK(least(points, t.kept) > 0.15);
    CHECK_THROWS_AS(thin(points, 0.2f, 0, {}), InputError);
    CHECK_THROWS_AS(thin(points, 0.2f, 5001, {}), InputError);
    CHECK_THROWS_AS(thin(points, 0, 5, {}), InputError);
    CHECK_THROWS_AS(thin({}, 1, 1, {}), InputError);
    Points broken = points;
    broken[7].y = std::numeric_limits<float>::infinity();
    CHECK_THROWS_AS(thin(broken, 0.2f, 5, {}), InputError);
}

// Expected: of a receiver in the middle of a cell of the lattice 8 probes are sqrt(3)/2 away, the next 24 sqrt(11)/2.
TEST_CASE("probes: the radius in closed form", "[probes][IPR 3.2.2.2]") {
    const Points probes = lattice(6, 6, 6);
    Points receivers(5, glm::vec4(2.5f, 2.5f, 2.5f, 7));
    PlacementParams params;
    CHECK(probe_radius(probes, receivers, params, {}).radius_m == Approx(std::sqrt(11.0) / 2).epsilon(1e-15));
    params.overlaps = 8;
    CHECK(probe_radius(probes, receivers, params, {}).mean_m == Approx(std::sqrt(3.0) / 2).epsilon(1e-15));
    // All have the same distance: at the mean every probe weighs 0, so that the default goes beyond.
    CHECK(probe_radius(probes, receivers, params, {}).radius_m == Approx(std::sqrt(3.0) / 2 * 17 / 16).epsilon(1e-15));
    params.radius_of = RadiusOf::mean;
    CHECK(probe_radius(probes, receivers, params, {}).radius_m == Approx(std::sqrt(3.0) / 2).epsilon(1e-15));
    // On a probe: that is the nearest, and six are 1 away. The mean of the two kinds.
    receivers.push_back({2, 2, 2, 0});
    params.overlaps = 7;
    const ProbeRadius r = probe_radius(probes, receivers, params, {});
    CHECK(r.mean_m == Approx((5 * std::sqrt(3.0) / 2 + 1) / 6).epsilon(1e-15));
    CHECK(r.largest_m == 17.0 / 16);
    CHECK(r.sampled == 6);
    // Fewer probes than overlaps: the farthest. One probe: its distance.
    CHECK(probe_radius(lattice(2, 1, 1), {{0, 0, 0, 0}}, {}, {}).radius_m == 1);
    CHECK(probe_radius({{3, 4, 0, 0}}, {{0, 0, 0, 0}}, {}, {}).mean_m == 5);
    // Of 10 receivers at 0, 1, ..., 9 every third is in a sample of four: (0 + 3 + 6 + 9) / 4.
    params = {}, params.sample_receivers = 4;
    const ProbeRadius sample = probe_radius({{0, 0, 0, 0}}, lattice(10, 1, 1), params, {});
    CHECK(sample.sampled == 4);
    CHECK(sample.mean_m == 4.5);
    CHECK(sample.largest_m == 9 * 17.0 / 16);
    params.radius_of = RadiusOf::largest;
    CHECK(probe_radius({{0, 0, 0, 0}}, lattice(10, 1, 1), params, {}).radius_m == sample.largest_m);

    CHECK_THROWS_WITH(probe_radius({}, receivers, {}, {}), "probes: no probes");
    CHECK_THROWS_WITH(probe_radius(probes, {}, {}, {}), "probes: no receivers");
    CHECK_THROWS_AS(probe_radius(probes, {{0, std::nanf(""), 0, 0}}, {}, {}), InputError);
    params = {}, params.overlaps = 17;
    CHECK_THROWS_WITH(probe_radius(probes, receivers, params, {}), Catch::StartsWith("probes: overlaps = 17"));
}

// Expected: by sorting all probes by (distance^2 in float, index).
TEST_CASE("probes.supports: the nearest probes, as by sorting", "[probes][IPR 3.2.3.2]") {
    Points probes = scattered(200, 5), receivers = scattered(150, 6);
    for (int i = 0; i < 40; ++i) probes[std::size_t(3 * i)] = probes[std::size_t(3 * i + 2)];  // equal distances
    for (const float radius : {0.2f, 2.0f})
        for (const int overlaps : {1, 10, 16}) {
            CAPTURE(radius, overlaps);
            const Supports s = run(SupportsInputs{&receivers, &probes, radius, overlaps}, {});
            REQUIRE(s.probe.size() == std::size_t(150 * overlaps));
            std::int64_t unsupported = 0, incomplete = 0;
            for (int r = 0; r < 150; ++r) {
                const glm::vec3 x(receivers[std::size_t(r)]);
                std::vector<std::pair<float, int>> sorted;
                for (int j = 0; j < 200; ++j) {
                    const float d2 = distance2<float>(glm::vec3(probes[std::size_t(j)]), x);
                    if (d2 < radius * radius) sorted.push_back({d2, j});
                }
                std::sort(sorted.begin(), sorted.end());
                unsupported += sorted.empty(), incomplete += !sorted.empty() && int(sorted.size()) < overlaps;
                for (int k = 0; k < overlaps; ++k) {
                    const std::size_t at = std::size_t(r * overlaps + k);
                    const bool there = k < int(sorted.size());
                    REQUIRE(s.probe[at] == (there ? sorted[std::size_t(k)].second : -1));
                    const double t = there ? std::sqrt(double(sorted[std::size_t(k)].first)) / double(radius) : 1;
                    REQUIRE(s.weight[at] == Approx(printed_weight(t)).margin(1e-6));
                    REQUIRE(s.weight[at] >= 0);
                }
            }
            CHECK(s.unsupported == unsupported);
            CHECK(s.incomplete == incomplete);
        }
}

TEST_CASE("probes.supports: one probe, equal distances, none in reach, what lies on the rim", "[probes][IPR 3.2.3.2]") {
    const Points at_origin = {{0, 0, 0, 0}};
    const Points receivers = {{0, 0, 0, 0}, {0.5f, 0, 0, 0}, {1, 0, 0, 0}, {5, 0, 0, 0}};
    const Supports one = run(SupportsInputs{&receivers, &at_origin, 1, 2}, {});
    CHECK(Indices(one.probe.begin(), one.probe.end()) == Indices{0, -1, 0, -1, -1, -1, -1, -1});
    CHECK(one.weight == Buffer<float>{1, 0, 0.5f, 0, 0, 0, 0, 0});  // w(0) = 1, w(1/2) = 1/2
    CHECK(one.unsupported == 2);
    CHECK(one.incomplete == 2);
    // Eight corners of a cube are equally far from its centre: the first of them are taken.
    const Points cube = lattice(2, 2, 2), centre = {{0.5f, 0.5f, 0.5f, 0}};
    const Supports equal = run(SupportsInputs{&centre, &cube, 1, 3}, {});
    CHECK(Indices(equal.probe.begin(), equal.probe.end()) == Indices{0, 1, 2});
    CHECK(equal.weight[0] == Approx(printed_weight(std::sqrt(0.75))).epsilon(1e-6));

    for (const float radius : {0.0f, -1.0f, std::nanf(""), 1e-40f})
        CHECK_THROWS_AS(run(SupportsInputs{&centre, &cube, radius, 3}, {}), InputError);
    for (const int overlaps : {0, 17}) CHECK_THROWS_AS(run(SupportsInputs{&centre, &cube, 1, overlaps}, {}), InputError);
    const Points none;
    CHECK_THROWS_WITH(run(SupportsInputs{&none, &cube, 1, 3}, {}), "probes.supports: no receivers");
    CHECK_THROWS_WITH(run(SupportsInputs{&centre, &none, 1, 3}, {}), "probes.supports: no probes");
    const Points nowhere = {{std::nanf(""), 0, 0, 0}};
    CHECK_THROWS_AS(run(SupportsInputs{&nowhere, &cube, 1, 3}, {}), InputError);
    CHECK_THROWS_AS(run(SupportsInputs{&centre, &nowhere, 1, 3}, {}), InputError);
}

// Expected: the published mean leaves receivers with fewer probes; the largest leaves none.
TEST_CASE("probes.supports: with the largest radius no receiver lacks a probe", "[probes][IPR 3.2.2.2]") {
    const Points probes = scattered(60, 7), receivers = scattered(2000, 8);
    const ProbeRadius r = probe_radius(probes, receivers, {}, {});
    const Supports mean = run(SupportsInputs{&receivers, &probes, float(r.mean_m), 10}, {});
    const Supports largest = run(SupportsInputs{&receivers, &probes, float(r.largest_m), 10}, {});
    CHECK(mean.incomplete > 500);
    CHECK(largest.unsupported + largest.incomplete == 0);
    for (const float w : largest.weight) CHECK(w > 0.00995f);  // w(16/17) = 49/4913 = 0.00997
}

TEST_CASE("probes.supports: the same bits for every instruction set and thread count, over several dispatches",
          "[probes][bits]") {
    const Points probes = scattered(33, 9), receivers = scattered(receivers_a_dispatch + 4321, 10);
    const SupportsInputs in{&receivers, &probes, 0.4f, 10};
    RunOptions scalar;
    scalar.isa = Isa::scalar, scalar.threads = 1;
    const Supports first = run(in, scalar);
    CHECK(first.weight.back() == 0);
    CHECK(first.probe[first.probe.size() - 10] >= 0);
    for_all_options([&](const RunOptions& options) {
        const Supports s = run(in, options);
        CHECK(s.probe == first.probe);
        CHECK(s.weight == first.weight);
    });
    // Each slot on its own, as the twin computes it.
    const StageData data = data_of(in, receivers_a_dispatch, 4321);
    const auto bound = stage<SupportsKernel>().bind(data);
    for (int i = 0; i < 4321; i += 97) {
        std::vector<double> out;
        for (int k = 0; k < 10; ++k) bound->in_double({k, i}, out);
        for (int k = 0; k < 10; ++k)
            CHECK(out[std::size_t(2 * k)] == first.probe[std::size_t(10 * (receivers_a_dispatch + i) + k)]);
    }
}

// Expected: by a power of two all numbers scale, so that indices and weights are the same bits.
TEST_CASE("probes.supports: at any scale", "[probes][scale]") {
    const Points probes = scattered(33, 11), receivers = scattered(200, 12);
    const Supports one = run(SupportsInputs{&receivers, &probes, 0.4f, 10}, {});
    for (const float s : {0x1p-13f, 0x1p20f, 1e-4f, 1e6f}) {
        Points p = probes, r = receivers;
        for (Points* list : {&p, &r})
            for (glm::vec4& x : *list) x *= s;
        const Supports scaled = run(SupportsInputs{&r, &p, 0.4f * s, 10}, {});
        CHECK(scaled.probe == one.probe);
        for (std::size_t i = 0; i < one.weight.size(); ++i) CHECK(scaled.weight[i] == Approx(one.weight[i]).margin(1e-6));
    }
}
