// The run time's update against sums in double, in closed form, level by level: probes.basis, probes.irradiance, probes.lightmap.
#include <algorithm>
#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "gi/lend.h"
#include "gi/probes/converge.h"
#include "gi/probes/update.h"
#include "probe_bakes.h"
#include "probe_transport.h"
#include "tests/parity/update_data.h"

using namespace plumb;
using namespace plumb::probes;
using namespace plumb::test;

namespace {

constexpr float nan_value = std::numeric_limits<float>::quiet_NaN();

bool same_bits(const glm::vec4& a, const glm::vec4& b) { return std::memcmp(&a, &b, sizeof a) == 0; }
bool same_bits(const Buffer<glm::vec4>& a, const Buffer<glm::vec4>& b) {
    return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), [](const auto& x, const auto& y) { return same_bits(x, y); });
}

RunOptions options_of(Isa isa, int threads) {
    RunOptions options;
    options.isa = isa, options.threads = threads;
    return options;
}

// Both stages, of clusters whose levels are `level`, receivers whose levels are `of_receiver` (both 0 if empty).
struct Update {
    std::vector<std::int32_t> level, of_receiver;
    glm::ivec4 used{64};
    Buffer<glm::vec4> basis, irradiance;

    void run(const ClusterData& d, const Buffer<glm::vec4>& lambda, const RunOptions& options = {}) {
        level.resize(d.clusters.size()), of_receiver.resize(d.receiver.size());
        BasisInputs b;
        b.clusters = &d, b.cluster_level = level.data(), b.lambda = lambda.data();
        b.probes = int(lambda.size()) / d.coefficients, b.coefficients = used;
        probes::run(b, options, basis);
        probes::run(IrradianceInputs{&d, level.data(), of_receiver.data(), basis.data()}, options, irradiance);
    }
    // Of a receiver.
    glm::dvec3 at(const ClusterData& d, std::size_t receiver) const { return glm::dvec3(irradiance[std::size_t(d.place_of[receiver])]); }
};

// I in double, from the lists as the bake has them, and what rounding may make of it: 2^-24 of the terms' magnitude for each of the
// products and sums on the way of one.
struct Reference {
    std::vector<glm::dvec3> irradiance, bound;

    Reference(const FlatClusters& f, int coefficients, const Buffer<glm::vec4>& lambda)
        : irradiance(f.cluster_of.size(), glm::dvec3(0)), bound(f.cluster_of.size(), glm::dvec3(0)) {
        std::size_t row = 0;
        for (std::size_t c = 0; c < f.rank.size(); ++c) {
            const std::size_t probes = std::size_t(f.first_probe[c + 1] - f.first_probe[c]);
            for (int s = 0; s < f.rank[c]; ++s, row += probes * std::size_t(coefficients)) {
                glm::dvec3 b(0), size(0);
                for (std::size_t k = 0; k < probes * std::size_t(coefficients); ++k) {
                    const std::size_t probe = std::size_t(f.probes[std::size_t(f.first_probe[c]) + k / std::size_t(coefficients)]);
                    const glm::dvec3 l(lambda[probe * std::size_t(coefficients) + k % std::size_t(coefficients)]);
                    const glm::dvec3 term = double(f.sigma_vt[row + k]) * l;
                    b += term, size += glm::abs(term);
                }
                for (int k = f.first_receiver[c]; k < f.first_receiver[c + 1]; ++k) {
                    const std::size_t i = std::size_t(f.receivers[std::size_t(k)]);
                    const double u = f.u[i * std::size_t(f.singular_values) + std::size_t(s)];
                    irradiance[i] += u * b;
                    bound[i] += std::fabs(u) * size * double(coefficients + int(probes) + f.rank[c] + 2) * 0x1p-24;
                }
            }
        }
    }
    // The largest share of the bound that is used. NaN is more than any.
    double used(const ClusterData& d, const Update& u) const {
        double most = 0;
        for (std::size_t i = 0; i < irradiance.size(); ++i)
            for (int c = 0; c < 3; ++c) {
                const double off = std::fabs(u.at(d, i)[c] - irradiance[i][c]);
                const double share = off == 0 ? 0 : off / bound[i][c];
                most = share <= most ? most : share;
            }
        return most;
    }
};

const std::vector<MadeCluster> all_kinds = {{150, 5, 32}, {1, 3, 1}, {70, 7, 17}, {33, 1, 16}, {64, 2, 31}, {9, 2, 0}, {200, 6, 24}, {40, 7, 5}};

struct Made {
    int probes = 11, coefficients = 16;
    FlatClusters flat = made_clusters(all_kinds, probes, coefficients, 32, 13, 5);
    int receivers = int(flat.cluster_of.size());
    ClusterData data = cluster_data(flat, receivers, coefficients);
    Buffer<glm::vec4> lambda = made_lambda(probes, coefficients, 6);
};

}  // namespace

TEST_CASE("run data: places are the receivers in the order of their clusters", "[probes][update]") {
    const Made m;
    const ClusterData& d = m.data;
    REQUIRE(d.count() == m.receivers);
    std::int32_t before = -1;
    for (int i = 0; i < d.count(); ++i) {
        const std::size_t place = std::size_t(i), receiver = std::size_t(d.receiver[place]);
        CHECK(d.place_of[receiver] == i);
        CHECK(d.cluster[place] == m.flat.cluster_of[receiver]);
        const bool next = i == 0 || d.cluster[place] != d.cluster[place - 1];
        CHECK((next || d.receiver[place] > d.receiver[place - 1]));
        if (next && d.cluster[place] >= 0) CHECK(d.cluster[place] == ++before);
        for (int s = 0; s < d.singular_values; ++s)
            CHECK(d.u[std::size_t(s) * std::size_t(d.count()) + place] == m.flat.u[receiver * std::size_t(d.singular_values) + std::size_t(s)]);
    }
    CHECK(std::count(d.cluster.end() - 13, d.cluster.end(), -1) == 13);
    // Lists that do not fit.
    FlatClusters other = m.flat;
    other.sigma_vt.pop_back();
    CHECK_THROWS_AS(cluster_data(other, m.receivers, m.coefficients), InputError);
    other = m.flat, other.receivers[0] = other.receivers[1];
    CHECK_THROWS_AS(cluster_data(other, m.receivers, m.coefficients), InputError);
    other = m.flat, other.rank[0] = 33;
    CHECK_THROWS_AS(cluster_data(other, m.receivers, m.coefficients), InputError);
    CHECK_THROWS_AS(cluster_data(m.flat, m.receivers - 1, m.coefficients), InputError);
    CHECK_THROWS_AS(cluster_data(m.flat, m.receivers, m.coefficients, {1, 2}), InputError);

    // Within a cluster the coarsest first, then ascending: any part that is computed lies side by side.
    std::vector<std::int32_t> level;
    for (int i = 0; i < m.receivers; ++i) level.push_back(int(4 * noise(i, 0, 0, 7)));
    const ClusterData ordered = cluster_data(m.flat, m.receivers, m.coefficients, level);
    CHECK(ordered.cluster == d.cluster);
    for (std::size_t i = 0; i < level.size(); ++i) {
        const std::int32_t receiver = ordered.receiver[i];
        CHECK(ordered.place_of[std::size_t(receiver)] == std::int32_t(i));
        CHECK(ordered.u[i] == m.flat.u[std::size_t(receiver) * std::size_t(d.singular_values)]);
        if (i == 0 || ordered.cluster[i] != ordered.cluster[i - 1] || ordered.cluster[i] < 0) continue;
        const std::int32_t one = ordered.receiver[i - 1];
        const int a = level[std::size_t(one)], b = level[std::size_t(receiver)];
        CHECK((a > b || (a == b && one < receiver)));
    }
}

TEST_CASE("update: U (Sigma V^T lambda), as in double, to rounding", "[probes][update]") {
    const Made m;
    Update u;
    u.run(m.data, m.lambda);
    const Reference truth(m.flat, m.coefficients, m.lambda);
    const double used = truth.used(m.data, u);
    CAPTURE(used);
    CHECK(used < 1);
    CHECK(used > 0.001);  // rounding is there, and the bound sees it
    // Beyond the rank the basis is 0; without a cluster all is.
    for (std::size_t c = 0; c < all_kinds.size(); ++c)
        for (int s = 0; s < 32; ++s) CHECK(same_bits(u.basis[32 * c + std::size_t(s)], glm::vec4(0)) == (s >= all_kinds[c].rank));
    for (int i = 0; i < m.data.count(); ++i) {
        const std::int32_t cluster = m.data.cluster[std::size_t(i)];
        CHECK(u.irradiance[std::size_t(i)].w == (cluster >= 0 ? 1 : 0));
        if (cluster < 0) CHECK(same_bits(u.irradiance[std::size_t(i)], glm::vec4(0)));
        if (cluster == 5) CHECK(same_bits(u.irradiance[std::size_t(i)], glm::vec4(0, 0, 0, 1)));  // rank 0
    }
}

// The loops over packets, and the tails of matrices and of clusters, against one item after the other.
TEST_CASE("update: the same bits for every instruction set, thread count, and item by item", "[probes][update][bits]") {
    for (const int singular_values : {4, 32, 64}) {
        std::vector<MadeCluster> kinds;
        for (int rank = 0; rank <= singular_values; ++rank) kinds.push_back({1 + (rank * 37) % 90, 1 + rank % 3, rank});
        const int probes = 5, coefficients = 9;
        const FlatClusters flat = made_clusters(kinds, probes, coefficients, singular_values, 3, 8);
        const ClusterData d = cluster_data(flat, int(flat.cluster_of.size()), coefficients);
        const Buffer<glm::vec4> lambda = made_lambda(probes, coefficients, 9);
        Update first;
        first.used = {9, 4, 1, 0};
        for (std::size_t c = 0; c < kinds.size(); ++c) first.level.push_back(std::int32_t(c % 6) - 1);  // -1 and 4: none
        for (int i = 0; i < d.count(); ++i) first.of_receiver.push_back(noise(i, 0, 0, 10) < 0.9f ? 3 : 0);
        first.run(d, lambda);
        for (const Isa isa : supported_isas())
            for (const int threads : {1, 3}) {
                Update other = first;
                other.run(d, lambda, options_of(isa, threads));
                CAPTURE(singular_values, isa_name(isa), threads);
                CHECK(same_bits(other.basis, first.basis));
                CHECK(same_bits(other.irradiance, first.irradiance));
            }
        NoTap tap;
        const BasisView b{{singular_values, int(kinds.size()), coefficients, probes, 9, 4, 1, 0}, &d.clusters[0].x, d.cluster_probes.data(),
                          first.level.data(), d.matrix.data(), &lambda[0].x, nullptr};
        int differ = 0;
        for (int c = 0; c < b.u.height; ++c)
            for (int s = 0; s < singular_values; ++s)
                differ += same_bits(basis<float>(b, s, c, tap), first.basis[std::size_t(c * singular_values + s)]) ? 0 : 1;
        CHECK(differ == 0);
        const IrradianceView e{{d.count(), 1, d.count(), int(kinds.size()), singular_values, {}}, &d.clusters[0].x, first.level.data(),
                               d.cluster.data(), first.of_receiver.data(), d.u.data(), &first.basis[0].x, nullptr};
        for (int i = 0; i < d.count(); ++i) differ += same_bits(irradiance<float>(e, i, 0, tap), first.irradiance[std::size_t(i)]) ? 0 : 1;
        CHECK(differ == 0);
    }
}

TEST_CASE("update: clusters of full rank give back the un-truncated transport, to rounding", "[probes][update][analytic]") {
    // Fewer receivers than singular values: nothing is cut off, and U Sigma V^T is A, of which each factor is rounded once.
    const int probes = 9, coefficients = 16, singular_values = 64;
    const plumb::Transport t = smooth_transport(600, probes, coefficients, 0.3, 4);
    ClusterParams params;
    params.singular_values = singular_values, params.most_receivers = singular_values, params.by_size_only = true;
    const FlatClusters flat = probes::flat(make_clusters(t.rows(), params, {}));
    const ClusterData d = cluster_data(flat, t.receivers, coefficients);
    REQUIRE(flat.count() > 9);
    for (int c = 0; c < flat.count(); ++c)
        REQUIRE(flat.rank[std::size_t(c)] == flat.first_value[std::size_t(c) + 1] - flat.first_value[std::size_t(c)]);
    const Buffer<glm::vec4> lambda = made_lambda(probes, coefficients, 3);
    Update u;
    u.run(d, lambda);
    const Reference clustered(flat, coefficients, lambda);
    CHECK(clustered.used(d, u) < 1);
    double worst = 0;
    for (int i = 0; i < t.receivers; ++i)
        for (int c = 0; c < 3; ++c) {
            double sum = 0;
            for (int s = 0; s < t.overlaps; ++s)
                for (int j = 0; j < coefficients; ++j) {
                    const std::size_t slot = std::size_t(i) * std::size_t(t.overlaps) + std::size_t(s);
                    const std::size_t probe = std::size_t(t.support[slot]);
                    sum += double(t.alpha[slot * std::size_t(coefficients) + std::size_t(j)]) *
                           double(lambda[probe * std::size_t(coefficients) + std::size_t(j)][c]);
                }
            const double off = std::fabs(u.at(d, std::size_t(i))[c] - sum), allowed = clustered.bound[std::size_t(i)][c] * 2;
            CHECK(off <= allowed);
            worst = std::max(worst, off / allowed);
        }
    CAPTURE(worst);
    CHECK(worst > 0);
}

TEST_CASE("update: of a bake the irradiance that converge.h has, to rounding", "[probes][update]") {
    BakeParams params = small();
    params.cluster_receivers = 100;
    const Scene scene = furnished();
    BakeGraph graph(scene, params);
    run_all(graph);
    const Bake& bake = graph.bake();
    const RunData d = run_data(bake, 3);
    CHECK(d.probes == int(bake.placement.probes.size()));
    CHECK(d.rays == params.relight_rays);
    REQUIRE(d.clusters.size() > 2);
    const Buffer<glm::vec4> lambda = made_lambda(d.probes, d.coefficients, 12);
    std::vector<glm::dvec3> exact;
    for (const glm::vec4& l : lambda) exact.emplace_back(l);
    const std::vector<glm::dvec3> expected = clustered_irradiance(bake, exact);
    Update u;
    u.run(d, lambda);
    const Reference truth(bake.flat, d.coefficients, lambda);
    for (std::size_t i = 0; i < expected.size(); ++i) CHECK(glm::length(expected[i] - truth.irradiance[i]) < 1e-12);
    CHECK(truth.used(d, u) < 1);

    // Permuted receivers: the same bits. Permuted probes: another order of the sums, and other roundings.
    FlatClusters turned = bake.flat;
    std::vector<std::int32_t> to(expected.size());
    for (std::size_t i = 0; i < to.size(); ++i) to[i] = std::int32_t(to.size() - 1 - i);
    for (std::int32_t& i : turned.receivers) i = to[std::size_t(i)];
    const std::size_t kept = std::size_t(turned.singular_values);
    for (std::size_t i = 0; i < to.size(); ++i) {
        turned.cluster_of[std::size_t(to[i])] = bake.flat.cluster_of[i];
        std::copy_n(&bake.flat.u[i * kept], kept, &turned.u[std::size_t(to[i]) * kept]);
    }
    const ClusterData of_turned = cluster_data(turned, int(to.size()), d.coefficients);
    Update other;
    other.run(of_turned, lambda);
    int differ = 0;
    for (std::size_t i = 0; i < to.size(); ++i) differ += other.at(of_turned, std::size_t(to[i])) == u.at(d, i) ? 0 : 1;
    CHECK(differ == 0);

    FlatClusters mirrored = bake.flat;
    std::size_t row = 0;
    for (std::size_t c = 0; c < mirrored.rank.size(); ++c) {
        const auto first = mirrored.probes.begin() + mirrored.first_probe[c], last = mirrored.probes.begin() + mirrored.first_probe[c + 1];
        std::reverse(first, last);
        const std::size_t n = std::size_t(last - first), block = std::size_t(d.coefficients);
        for (int s = 0; s < mirrored.rank[c]; ++s, row += n * block)
            for (std::size_t k = 0; k < n; ++k)
                std::copy_n(&bake.flat.sigma_vt[row + k * block], block, &mirrored.sigma_vt[row + (n - 1 - k) * block]);
    }
    const ClusterData of_mirrored = cluster_data(mirrored, int(to.size()), d.coefficients);
    other.run(of_mirrored, lambda);
    for (std::size_t i = 0; i < to.size(); ++i) {
        differ += other.at(of_mirrored, i) == u.at(d, i) ? 0 : 1;
        for (int c = 0; c < 3; ++c) CHECK(std::fabs(other.at(of_mirrored, i)[c] - u.at(d, i)[c]) <= 2 * truth.bound[i][c]);
    }
    CHECK(differ > 0);
}

TEST_CASE("update: what is not computed is 0, and nothing of it is read", "[probes][update][lod]") {
    Made m;
    Update all;
    all.run(m.data, m.lambda);
    // Levels 0 to 3 of clusters and receivers; the other bits are those of what is computed whole.
    Update some;
    for (std::size_t c = 0; c < m.data.clusters.size(); ++c) some.level.push_back(std::int32_t(c % 4));
    for (int i = 0; i < m.data.count(); ++i) some.of_receiver.push_back(i % 4);
    some.run(m.data, m.lambda);
    int computed = 0;
    for (int i = 0; i < m.data.count(); ++i) {
        const std::size_t place = std::size_t(i);
        const std::int32_t cluster = m.data.cluster[place];
        const bool shown = cluster >= 0 && i % 4 >= cluster % 4;
        CHECK(same_bits(some.irradiance[place], shown ? all.irradiance[place] : glm::vec4(0)));
        computed += shown ? 1 : 0;
    }
    CHECK(computed > 100);
    // All clusters left out: zeros.
    Update none;
    none.level.assign(m.data.clusters.size(), 4);
    none.run(m.data, m.lambda);
    CHECK(same_bits(none.basis, Buffer<glm::vec4>(none.basis.size(), glm::vec4(0))));
    CHECK(same_bits(none.irradiance, Buffer<glm::vec4>(none.irradiance.size(), glm::vec4(0))));

    // A level's coefficients: as if those beyond it were 0; they are not read.
    Update few;
    few.used = {16, 9, 4, 1};
    few.level.assign(m.data.clusters.size(), 1);
    few.of_receiver.assign(m.data.receiver.size(), 3);
    Buffer<glm::vec4> cut = m.lambda, poisoned = m.lambda;
    for (std::size_t k = 0; k < cut.size(); ++k)
        if (k % 16 >= 9) cut[k] = glm::vec4(0), poisoned[k] = glm::vec4(nan_value);
    few.run(m.data, poisoned);
    CHECK(Reference(m.flat, 16, cut).used(m.data, few) < 1);
    const Buffer<glm::vec4> nine = few.irradiance;
    few.used = {0, 0, 0, 0};
    few.run(m.data, poisoned);
    for (const glm::vec4& e : few.irradiance) CHECK(glm::vec3(e) == glm::vec3(0));
    CHECK_FALSE(same_bits(few.irradiance, nine));
}

TEST_CASE("update: NaN shows where it goes, and nowhere else", "[probes][update]") {
    Made m;
    m.lambda[3 * 16 + 5].y = nan_value;  // of probe 3
    Update u;
    u.run(m.data, m.lambda);
    int seen = 0;
    for (int i = 0; i < m.data.count(); ++i) {
        const std::size_t place = std::size_t(i);
        const std::int32_t c = m.data.cluster[place];
        bool asks = false;
        if (c >= 0 && m.data.clusters[std::size_t(c)].w > 0)
            for (int k = 0; k < m.data.clusters[std::size_t(c)].z; ++k)
                asks = asks || m.data.cluster_probes[std::size_t(m.data.clusters[std::size_t(c)].y + k)] == 3;
        CHECK(std::isnan(u.irradiance[place].y) == asks);
        CHECK_FALSE(std::isnan(u.irradiance[place].x));
        if (!asks) continue;
        CHECK(std::bit_cast<std::uint32_t>(u.irradiance[place].y) == 0x7fc00000u);
        ++seen;
    }
    CHECK(seen > 50);
    // A receiver's own, and of what lies beyond its cluster's rank nothing.
    Made other;
    const std::size_t places = std::size_t(other.data.count());
    other.data.u[4 * places + 17] = nan_value;       // cluster 0
    const std::size_t last = std::size_t(other.data.place_of[std::size_t(other.flat.receivers.back())]);
    REQUIRE(other.data.cluster[last] == 7);          // of rank 5
    other.data.u[5 * places + last] = nan_value;
    u.run(other.data, other.lambda);
    for (std::size_t i = 0; i < places; ++i) CHECK(std::isnan(u.irradiance[i].x) == (i == 17));
}

TEST_CASE("update: tables that lead beyond what there is are refused", "[probes][update]") {
    const Made m;
    const auto refused = [&](auto change) {
        Made other = m;
        Update u;
        change(other, u);
        try {
            u.run(other.data, other.lambda);
        } catch (const InputError& e) {
            return std::string(e.what());
        }
        return std::string();
    };
    CHECK(refused([](Made&, Update&) {}) == "");
    using Catch::Contains;
    for (const int column : {0, 1, 2, 3})
        CHECK_THAT(refused([&](Made& o, Update&) { o.data.clusters[2][column] = -1; }), Contains("cluster 2: "));
    CHECK_THAT(refused([](Made& o, Update&) { o.data.clusters[2].w = 33; }), Contains("cluster 2: "));
    CHECK_THAT(refused([](Made& o, Update&) { o.data.clusters[2].z = 12; }), Contains("at most 11 probes"));
    CHECK_THAT(refused([](Made& o, Update&) { o.data.clusters[7].x += 1; }), Contains("matrix") && Contains("all clusters' matrices"));
    CHECK_THAT(refused([](Made& o, Update&) { o.data.clusters[7].y += 1; }), Contains("cluster_probes"));
    CHECK_THAT(refused([](Made& o, Update&) { o.data.cluster_probes[4] = 11; }), Contains("cluster 0: probe 11 of 11"));
    CHECK_THAT(refused([](Made& o, Update&) { o.data.cluster_probes[4] = -1; }), Contains("cluster 0: probe -1 of 11"));
    CHECK_THAT(refused([](Made& o, Update&) { o.lambda.resize(10 * 16); }), Contains("probe"));
    CHECK_THAT(refused([](Made& o, Update&) { o.data.clusters.clear(); }), Contains("no clusters"));
    CHECK_THAT(refused([](Made&, Update& u) { u.used.z = -1; }), Contains("coefficients_2"));
    // A cluster that is none, or a place whose cluster is none: not computed.
    Made other = m;
    other.data.cluster[0] = 8, other.data.cluster[1] = -5;
    Update u;
    u.run(other.data, other.lambda);
    CHECK((same_bits(u.irradiance[0], glm::vec4(0)) && same_bits(u.irradiance[1], glm::vec4(0))));
    CHECK(u.irradiance[2].w == 1);
}
