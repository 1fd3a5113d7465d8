// Clusters of receivers: the tree's properties, Eigen's decompositions as the truth, extremes, bits.
#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <Eigen/SVD>
#include <numeric>

#include "core/content_hasher.h"
#include "core/error.h"
#include "gi/probes/clusters.h"
#include "tests/gi/probe_transport.h"

using namespace plumb;
using namespace plumb::probes;
using Eigen::MatrixXd;

namespace {

MatrixXd rows_of(const Transport& t, const std::vector<std::int32_t>& receivers,
                 const std::vector<std::int32_t>& probes) {
    MatrixXd m = MatrixXd::Zero(Eigen::Index(receivers.size()), Eigen::Index(probes.size()) * t.coefficients);
    for (std::size_t i = 0; i < receivers.size(); ++i)
        for (int s = 0; s < t.overlaps; ++s) {
            const std::size_t slot = std::size_t(receivers[i]) * t.overlaps + s;
            if (t.support[slot] < 0) continue;
            const auto p = std::find(probes.begin(), probes.end(), t.support[slot]) - probes.begin();
            for (int c = 0; c < t.coefficients; ++c)
                m(Eigen::Index(i), p * t.coefficients + c) = t.alpha[slot * t.coefficients + c];
        }
    return m;
}

std::vector<std::int32_t> probes_of(const Transport& t, const std::vector<std::int32_t>& receivers) {
    std::vector<std::int32_t> probes;
    for (int p = 0; p < 1000; ++p)
        for (std::int32_t r : receivers) {
            const auto* s = &t.support[std::size_t(r) * t.overlaps];
            if (std::find(s, s + t.overlaps, p) == s + t.overlaps) continue;
            probes.push_back(p);
            break;
        }
    return probes;
}

// The published tree, by the book: halves of halves, an empty one is dropped, a full decomposition each.
void published_tree(const Transport& t, const ClusterParams& p, glm::dvec3 low, glm::dvec3 high,
                    const std::vector<std::int32_t>& receivers, std::vector<std::vector<std::int32_t>>& leaves) {
    if (receivers.empty()) return;
    if (int(receivers.size()) < p.most_receivers) {
        if (p.by_size_only || int(receivers.size()) <= p.always_accepted) return leaves.push_back(receivers);
        const MatrixXd a = rows_of(t, receivers, probes_of(t, receivers));
        const auto s = Eigen::BDCSVD<MatrixXd>(a).singularValues();
        const double kept = s.head(std::min<Eigen::Index>(s.size(), p.singular_values)).sum();
        if (1 - std::sqrt(kept / s.sum()) < p.threshold) return leaves.push_back(receivers);
    }
    int axis = 0;
    for (int a : {1, 2})
        if (high[a] - low[a] > high[axis] - low[axis]) axis = a;
    glm::dvec3 middle_high = high, middle_low = low;
    middle_high[axis] = middle_low[axis] = (low[axis] + high[axis]) / 2;
    std::vector<std::int32_t> side[2];
    for (std::int32_t r : receivers) side[t.position[r][axis] >= middle_low[axis]].push_back(r);
    published_tree(t, p, low, middle_high, side[0], leaves);
    published_tree(t, p, middle_low, high, side[1], leaves);
}

std::vector<std::vector<std::int32_t>> published_tree(const Transport& t, const ClusterParams& p) {
    std::vector<std::int32_t> receivers(std::size_t(t.receivers));
    std::iota(receivers.begin(), receivers.end(), 0);
    glm::dvec3 low(t.position[0]), high = low;
    for (const glm::vec4& x : t.position) low = glm::min(low, glm::dvec3(x)), high = glm::max(high, glm::dvec3(x));
    std::vector<std::vector<std::int32_t>> leaves;
    published_tree(t, p, low, high, receivers, leaves);
    return leaves;
}

std::uint64_t hash_of(const Clusters& clusters) {
    ContentHasher h;
    h.add_all(clusters.cluster_of), h.add_all(clusters.u);
    for (const Cluster& c : clusters.clusters) {
        h.add_all(c.receivers), h.add_all(c.probes), h.add_all(c.sigma_vt);
        h.add_all(c.singular_values), h.add_all(c.spectrum);
        h.add(c.rank, c.sum_of_all, c.error_published, c.error_frobenius, c.low, c.high, c.cell_low, c.cell_high);
    }
    return h.hash;
}

// What every clustering has to hold; returns the Frobenius norm of all that was cut off, as stored.
double require_clusters(const Transport& t, const ClusterParams& p, const Clusters& clusters,
                        const ClusterReport& report) {
    std::vector<int> times(std::size_t(t.receivers));
    int of_rank = 0, coincident = 0;
    double lost = 0;
    REQUIRE(clusters.singular_values == p.singular_values);
    REQUIRE(clusters.u.size() == std::size_t(t.receivers) * p.singular_values);
    for (std::size_t k = 0; k < clusters.clusters.size(); ++k) {
        CAPTURE(k);
        const Cluster& c = clusters.clusters[k];
        REQUIRE(!c.receivers.empty());
        REQUIRE(int(c.receivers.size()) < p.most_receivers);
        REQUIRE(std::is_sorted(c.receivers.begin(), c.receivers.end()));
        REQUIRE(c.probes == probes_of(t, c.receivers));
        REQUIRE(c.rank <= p.singular_values);
        REQUIRE(int(c.singular_values.size()) == c.rank);
        REQUIRE(c.sigma_vt.size() == std::size_t(c.rank) * c.probes.size() * t.coefficients);
        glm::vec3 low(t.position[c.receivers[0]]), high = low;
        for (std::int32_t r : c.receivers) {
            ++times[r];
            REQUIRE(clusters.cluster_of[r] == std::int32_t(k));
            low = glm::min(low, glm::vec3(t.position[r])), high = glm::max(high, glm::vec3(t.position[r]));
            for (int i = c.rank; i < p.singular_values; ++i)
                REQUIRE(clusters.u[std::size_t(r) * p.singular_values + i] == 0);
        }
        REQUIRE(low == c.low);
        REQUIRE(high == c.high);
        REQUIRE(glm::all(glm::lessThanEqual(c.cell_low, glm::dvec3(low))));
        REQUIRE(glm::all(glm::greaterThanEqual(c.cell_high, glm::dvec3(high))));

        const bool above = !(c.error_published < p.threshold);
        const bool excused = p.by_size_only || int(c.receivers.size()) <= p.always_accepted || low == high;
        REQUIRE((!above || excused));
        coincident += above && low == high;
        REQUIRE(c.sum_of_all == Approx(std::accumulate(c.spectrum.begin(), c.spectrum.end(), 0.0)));
        ++of_rank;

        // What is stored, in float, against A.
        const MatrixXd a = rows_of(t, c.receivers, c.probes);
        MatrixXd product = MatrixXd::Zero(a.rows(), a.cols());
        for (Eigen::Index i = 0; i < a.rows(); ++i)
            for (int s = 0; s < c.rank; ++s)
                for (Eigen::Index j = 0; j < a.cols(); ++j)
                    product(i, j) += double(clusters.u[std::size_t(c.receivers[i]) * p.singular_values + s]) *
                                     c.sigma_vt[std::size_t(s) * a.cols() + j];
        const double error = (a - product).norm(), norm = a.norm();
        CHECK(error <= 1.0001 * c.error_frobenius * norm + 2e-7 * norm);
        CHECK(error >= 0.9999 * c.error_frobenius * norm - 2e-7 * norm);
        lost += error * error;
    }
    int without = 0;
    for (int r = 0; r < t.receivers; ++r) {
        const auto* s = &t.support[std::size_t(r) * t.overlaps];
        const bool any = std::any_of(s, s + t.overlaps, [](int probe) { return probe >= 0; });
        REQUIRE(times[r] == int(any));
        if (any) continue;
        ++without;
        REQUIRE(clusters.cluster_of[r] == -1);
        for (int i = 0; i < p.singular_values; ++i) REQUIRE(clusters.u[std::size_t(r) * p.singular_values + i] == 0);
    }
    CHECK(report.without_probe == without);
    CHECK(report.coincident == coincident);
    CHECK(report.decompositions == report.rejected + int(clusters.clusters.size()));
    CHECK(report.rejected_early <= report.rejected);
    CHECK(std::accumulate(report.of_rank.begin(), report.of_rank.end(), 0) == of_rank);
    return std::sqrt(lost);
}

struct Clustered {
    Clusters clusters;
    ClusterReport report;
    Clustered(const Transport& t, const ClusterParams& p, const RunOptions& options = {}) {
        clusters = make_clusters(t.rows(), p, options, &report);
        require_clusters(t, p, clusters, report);
    }
};

std::vector<std::size_t> sizes(const Clusters& c) {
    std::vector<std::size_t> s;
    for (const Cluster& k : c.clusters) s.push_back(k.receivers.size());
    return s;
}

// Receivers at these places, each with probe 0 alone and one coefficient, so that rank is 1 and the error 0.
Transport places(const std::vector<glm::vec3>& x) {
    Transport t{int(x.size()), 1, 1, {}, {}, {}};
    for (const glm::vec3& p : x) t.position.emplace_back(p, 0), t.support.push_back(0), t.alpha.push_back(1);
    return t;
}

ClusterParams params(double threshold, int most = 1024, int always = 32) {
    ClusterParams p;
    p.threshold = threshold, p.most_receivers = most, p.always_accepted = always;
    return p;
}

std::string message_of(const Transport& t, const ClusterParams& p = {}) {
    try {
        make_clusters(t.rows(), p, {});
    } catch (const InputError& e) {
        return e.what();
    }
    return "accepted";
}

}  // namespace

TEST_CASE("clusters: those of the published tree with full decompositions", "[probes][IPR 3.2.4]") {
    for (double noise : {0.0, 0.02})
        for (double threshold : {0.0001, 0.005, 0.05}) {
            const Transport t = smooth_transport(500, 20, 9, noise);
            const ClusterParams p = params(threshold, 400);
            CAPTURE(noise, threshold);
            const Clustered c(t, p);
            const auto leaves = published_tree(t, p);
            REQUIRE(leaves.size() == c.clusters.clusters.size());
            for (std::size_t k = 0; k < leaves.size(); ++k) CHECK(leaves[k] == c.clusters.clusters[k].receivers);
        }
}

TEST_CASE("clusters: a lower threshold splits further", "[probes][IPR figure 3.19]") {
    const Transport t = smooth_transport(900, 20, 16);
    const std::size_t by_size = [&] {
        ClusterParams p = params(0.005, 500);
        p.by_size_only = true;
        const Clustered c(t, p);
        CHECK(c.report.rejected == 0);
        CHECK(published_tree(t, p).size() == c.clusters.clusters.size());
        return c.clusters.clusters.size();
    }();
    const std::size_t coarse = Clustered(t, params(0.02, 500)).clusters.clusters.size();
    const std::size_t fine = Clustered(t, params(0.002, 500)).clusters.clusters.size();
    CHECK(by_size < coarse);
    CHECK(coarse < fine);
}

TEST_CASE("clusters: a grid is halved at its middles, low side first", "[probes][IPR figure 3.18][analytic]") {
    // 64 x 32 places 1 m apart: 63 m x 31 m. Fewer than 600: x is halved, x again (31.5 > 31), that is 4 of 16 x 32 =
    // 512.
    std::vector<glm::vec3> x;
    for (int j = 0; j < 32; ++j)
        for (int i = 0; i < 64; ++i) x.emplace_back(i, 7, j);
    const Clustered four(places(x), params(0.005, 600));
    REQUIRE(sizes(four.clusters) == std::vector<std::size_t>{512, 512, 512, 512});
    for (int r = 0; r < 2048; ++r) CHECK(four.clusters.cluster_of[r] == r % 64 / 16);
    CHECK(four.clusters.clusters[1].cell_low == glm::dvec3(15.75, 7, 0));
    CHECK(four.clusters.clusters[1].cell_high == glm::dvec3(31.5, 7, 31));
    CHECK(four.clusters.clusters[1].low == glm::vec3(16, 7, 0));
    CHECK(four.clusters.clusters[1].high == glm::vec3(31, 7, 31));
    // Exactly 512 is not fewer than 512: z is next.
    const Clustered eight(places(x), params(0.005, 512));
    REQUIRE(sizes(eight.clusters) == std::vector<std::size_t>(8, 256));
    for (int r = 0; r < 2048; ++r) CHECK(eight.clusters.cluster_of[r] == r % 64 / 16 * 2 + r / 64 / 16);
    // All rows are the same: one singular value, sqrt(256).
    for (const Cluster& c : eight.clusters.clusters) {
        REQUIRE(c.rank == 1);
        CHECK(c.singular_values[0] == Approx(16).epsilon(1e-14));
        CHECK(c.sigma_vt == std::vector<float>{16});
        CHECK(c.error_published == 0);
    }
    CHECK(eight.report.of_rank[1] == 8);
    CHECK(eight.report.split_at_median == 0);
    // What lies on the middle belongs to the high side; of axes that are equally long, the first is halved.
    CHECK(Clustered(places({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}), params(0.005, 3)).clusters.cluster_of ==
          std::vector<std::int32_t>{0, 1, 1});
    CHECK(Clustered(places({{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0}}), params(0.005, 3)).clusters.cluster_of ==
          std::vector<std::int32_t>{0, 0, 1, 1});
}

TEST_CASE("clusters: 32 receivers or fewer are always accepted and exact", "[probes][IPR 3.2.4.2]") {
    Transport t = smooth_transport(32, 10, 64, 5.0);
    t.position.assign(32, glm::vec4(0));
    for (int i = 0; i < 32; ++i) t.position[i].x = float(i);
    const Clustered all(t, params(0));
    REQUIRE(sizes(all.clusters) == std::vector<std::size_t>{32});
    CHECK(all.clusters.clusters[0].rank == 32);
    CHECK(all.clusters.clusters[0].error_published == 0);
    CHECK(all.clusters.clusters[0].error_frobenius == 0);
    // No error is below 0: everything larger is split.
    CHECK(sizes(Clustered(t, params(0, 1024, 16)).clusters) == std::vector<std::size_t>{16, 16});
}

TEST_CASE("clusters: receivers in one point are accepted and counted, or halved where they are too many",
          "[probes][extreme]") {
    Transport t = smooth_transport(100, 12, 16, 5.0);
    t.position.assign(100, glm::vec4(1, 2, 3, 0));
    const Clustered one(t, params(0.005));
    CHECK(sizes(one.clusters) == std::vector<std::size_t>{100});
    CHECK(one.clusters.clusters[0].error_published > 0.005);
    CHECK(one.report.coincident == 1);
    const Clustered many(t, params(0.005, 50));
    CHECK(sizes(many.clusters) == std::vector<std::size_t>{25, 25, 25, 25});
    CHECK(many.report.coincident == 0);  // 25 are accepted anyhow
    CHECK(many.report.split_at_median == 3);
    for (int r = 0; r < 100; ++r) CHECK(many.clusters.cluster_of[r] == r / 25);
}

TEST_CASE("clusters: where no middle comes between receivers, their median does", "[probes][extreme]") {
    // From a box of 1e30 to 60 receivers within 6 cm it would take 102 halvings an axis.
    std::vector<glm::vec3> x = {{1e30f, 1e30f, 1e30f}, {-3e29f, -3e29f, -3e29f}};
    for (int i = 0; i < 60; ++i) x.emplace_back(1e-3f * float(i), 0, 0);
    const Clustered c(places(x), params(0.005, 20));
    CHECK(c.report.split_at_median > 0);
    CHECK(c.clusters.clusters.size() >= 6);
    // Of receivers in a row, clusters are a partition into intervals.
    for (std::size_t r = 3; r < x.size(); ++r) CHECK(c.clusters.cluster_of[r] - c.clusters.cluster_of[r - 1] <= 1);
    for (std::size_t r = 3; r < x.size(); ++r) CHECK(c.clusters.cluster_of[r] >= c.clusters.cluster_of[r - 1]);

    // The smallest floats are told apart, too.
    const Clustered three(places({{0, 0, 0}, {1e-45f, 0, 0}, {1e38f, 0, 0}}), params(0.005, 2, 1));
    CHECK(three.clusters.cluster_of == std::vector<std::int32_t>{0, 1, 2});
}

TEST_CASE("clusters: receivers without a probe are left out", "[probes]") {
    Transport t = smooth_transport(300, 8, 4);
    for (int r = 0; r < 300; r += 3)
        for (int s = 0; s < t.overlaps; ++s) t.support[std::size_t(r) * t.overlaps + s] = -1;
    t.position[0].x = 1e6f;  // it does not stretch the box
    const Clustered c(t, params(0.005, 100));
    CHECK(c.report.without_probe == 100);
    CHECK(c.clusters.clusters.back().cell_high.x <= 6);
    for (std::int32_t& s : t.support) s = -1;
    const Clustered none(t, params(0.005));
    CHECK(none.clusters.clusters.empty());
    CHECK(none.report.decompositions == 0);
}

TEST_CASE("clusters: none, one receiver, one probe, coefficients that are all 0", "[probes][extreme]") {
    Transport nothing{0, 10, 64, {}, {}, {}};
    CHECK(Clustered(nothing, {}).clusters.clusters.empty());

    const Clustered one(smooth_transport(1, 5, 64), {});
    REQUIRE(one.clusters.clusters.size() == 1);
    CHECK(one.clusters.clusters[0].rank == 1);
    CHECK(one.clusters.u[0] == 1);

    const Clustered probe(smooth_transport(400, 1, 4, 0, 3), params(0.005));
    REQUIRE(probe.clusters.clusters.size() == 1);
    CHECK(probe.clusters.clusters[0].rank <= 4);
    CHECK(probe.clusters.clusters[0].error_frobenius == 0);

    Transport zero = smooth_transport(200, 5, 4);
    std::fill(zero.alpha.begin(), zero.alpha.end(), 0.0f);
    const Clustered z(zero, params(0.005));
    REQUIRE(z.clusters.clusters.size() == 1);
    CHECK(z.clusters.clusters[0].rank == 0);
    CHECK(z.report.of_rank[0] == 1);
}

TEST_CASE("clusters: of alphas near 1e-30 and 1e+30 the same ones", "[probes][extreme]") {
    Transport t = smooth_transport(400, 15, 9);
    const Clustered one(t, params(0.005));
    for (double scale : {0x1p100, 0x1p-200}) {
        for (float& a : t.alpha) a = float(a * scale);
        const Clustered c(t, params(0.005));
        CHECK(c.clusters.cluster_of == one.clusters.cluster_of);
        CHECK(c.clusters.u == one.clusters.u);
        CHECK(c.clusters.clusters[0].error_published == one.clusters.clusters[0].error_published);
    }
    // Next to each other: every second receiver is nothing to the other ones.
    for (int r = 0; r < 400; ++r)
        for (int i = 0; i < 10 * 9; ++i) t.alpha[std::size_t(r) * 90 + i] *= r % 2 ? 0x1p+100f : 0x1p+0f;
    Clustered(t, params(0.005));
}

TEST_CASE("clusters: the same bits for any number of threads and on every instruction set", "[probes][bits]") {
    const Transport t = smooth_transport(1200, 20, 16, 0.003);
    const ClusterParams p = params(0.005, 500);
    const Clusters first = make_clusters(t.rows(), p, {Isa::scalar, 1, {}});
    CHECK(first.clusters.size() > 4);
    for (int threads : {1, 2, 3})
        for (Isa isa : supported_isas()) {
            CAPTURE(threads, isa_name(isa));
            CHECK(hash_of(make_clusters(t.rows(), p, {isa, threads, {}})) == hash_of(first));
        }
    // Golden: made by this code; the same of g++ 12 and clang 14.
    CHECK(hash_text(hash_of(first)) == "53fc4b3b0ba5cf00");
}

TEST_CASE("clusters: progress is a share of the receivers", "[probes]") {
    const Transport t = smooth_transport(800, 15, 9);
    std::atomic<int> calls{0};
    double last = 0;
    bool within = true;
    RunOptions options{best_isa(), 1, [&](double share) {
                           within = within && share > last && share <= 1;
                           last = share;
                           ++calls;
                       }};
    const Clusters c = make_clusters(t.rows(), params(0.005, 300), options);
    CHECK(within);
    CHECK(last == 1);
    CHECK(calls == int(c.clusters.size()));
}

TEST_CASE("clusters: errors of fewer or more singular values, without another decomposition", "[probes]") {
    const Transport t = smooth_transport(500, 20, 16, 0.01);
    ClusterParams p = params(0.005, 200);
    p.by_size_only = true;
    const Clustered c(t, p);
    for (int kept : {4, 8, 16, 32, 48, 64}) {
        CAPTURE(kept);
        p.singular_values = kept;
        const Clustered other(t, p);
        double squares = 0, all = 0;
        for (std::size_t k = 0; k < c.clusters.clusters.size(); ++k) {
            const TruncationError e = truncation_error(c.clusters.clusters[k], kept);
            const Cluster& o = other.clusters.clusters[k];
            CHECK(e.published == Approx(o.error_published).epsilon(1e-9).margin(1e-12));
            CHECK(e.frobenius == Approx(o.error_frobenius).epsilon(1e-9).margin(1e-12));
            const double norm = rows_of(t, o.receivers, o.probes).norm();
            squares += std::pow(e.frobenius * norm, 2), all += norm * norm;
        }
        CHECK(truncation_error(c.clusters, kept).frobenius == Approx(std::sqrt(squares / all)).epsilon(1e-9));
        const double lost = require_clusters(t, p, other.clusters, other.report);
        CHECK(lost == Approx(std::sqrt(squares)).epsilon(1e-3).margin(2e-7 * std::sqrt(all)));
    }
    CHECK(truncation_error(c.clusters, 200).published == 0);
}

TEST_CASE("clusters: what is refused, in one line", "[probes]") {
    const Transport good = smooth_transport(40, 12, 4);
    CHECK(message_of(good) == "accepted");
    auto with = [&](auto change) {
        Transport t = good;
        change(t);
        return message_of(t);
    };
    CHECK(with([](Transport& t) { t.slot(7, 2)[3] = NAN; }) ==
          "clusters: receiver 7: coefficient 3 of probe " + std::to_string(good.support[72]) + " is not finite");
    CHECK(with([](Transport& t) { t.slot(39, 0)[0] = -INFINITY; }).find("receiver 39: coefficient 0") !=
          std::string::npos);
    CHECK(with([](Transport& t) { t.slot(3, 0)[1] = 2e36f; }).find("is larger than 1e36") != std::string::npos);
    CHECK(with([](Transport& t) { t.position[5].y = NAN; }) == "clusters: receiver 5: its position is not finite");
    CHECK(with([](Transport& t) { t.position[5].w = NAN; }) == "accepted");
    CHECK(with([](Transport& t) { t.support[11] = -2; }) == "clusters: receiver 1: there is no probe -2");
    CHECK(with([](Transport& t) { t.support[13] = t.support[10] = 5, t.support[11] = t.support[12] = -1; }) ==
          "clusters: receiver 1: it has probe 5 twice");
    // What an empty slot holds is not read.
    CHECK(with([](Transport& t) { t.support[11] = -1, t.slot(1, 1)[0] = NAN; }) == "accepted");
    CHECK(with([](Transport& t) { t.coefficients = 5; }) == "clusters: coefficients is 5; it may be 1, 4, 9 ... 64");
    CHECK(with([](Transport& t) { t.overlaps = 0; }) == "clusters: overlaps is 0; it may be 1 to 64");

    auto setting = [&](auto change) {
        ClusterParams p;
        change(p);
        return message_of(good, p);
    };
    CHECK(setting([](ClusterParams& p) { p.singular_values = 3; }) ==
          "clusters: singular_values is 3; it may be 4 to 64");
    CHECK(setting([](ClusterParams& p) { p.singular_values = 65; }).find("65") != std::string::npos);
    CHECK(setting([](ClusterParams& p) { p.threshold = NAN; }) == "clusters: threshold is not between 0 and 1");
    CHECK(setting([](ClusterParams& p) { p.most_receivers = 1; }) ==
          "clusters: most_receivers is 1; it may be 2 to 4096");
    CHECK(setting([](ClusterParams& p) { p.always_accepted = 0; }) ==
          "clusters: always_accepted is 0; it may be 1 to 4096");
}
