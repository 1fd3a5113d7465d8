// What clusters may take at most, against what they take.
#include <catch2/catch.hpp>

#include "gi/probes/cluster_tree.h"
#include "gi/probes/memory.h"
#include "probe_transport.h"

using namespace plumb;
using namespace plumb::probes;

namespace {

ClusterBound taken_by(const Clusters& clusters) {
    ClusterBound b;
    b.clusters = clusters.clusters.size();
    for (const Cluster& c : clusters.clusters) b.matrices += c.sigma_vt.size(), b.spectrum += c.spectrum.size();
    return b;
}

}  // namespace

TEST_CASE("memory: sizes in units that say something", "[probes][memory]") {
    CHECK(size_text(1000000) == "1 MB");
    CHECK(size_text(23456789) == "23.5 MB");
    CHECK(size_text(1440000000) == "1.4 GB");
}

TEST_CASE("clusters: the bound of one cluster in closed form", "[probes][memory]") {
    // 10 receivers, each with all of 3 probes of 4 coefficients: 10 x 12, rank 10; of 64 receivers rank 12.
    for (const int receivers : {10, 31}) {
        const Transport t = smooth_transport(receivers, 3, 4, 0.1, 3);
        const ClusterBound b = cluster_bound(t.rows(), {});
        CHECK(b.matrices == std::uint64_t(std::min(receivers, 12) * 12));
        CHECK(b.spectrum == std::uint64_t(std::min(receivers, 12)));
        CHECK(b.clusters == 1);
        CHECK(b.lists == std::uint64_t(receivers + 3));
    }
    const Transport none;
    CHECK(cluster_bound(none.rows(), {}).matrices == 0);
}

TEST_CASE("clusters: the bound holds, and is met where the tree is known", "[probes][memory]") {
    const Transport t = smooth_transport(3000, 30, 16, 0.2);  // noise has full rank
    for (const bool by_size_only : {true, false})
        for (const double threshold : {0.0, 0.01, 0.3})
            for (const int kept : {4, 32}) {
                ClusterParams p;
                p.by_size_only = by_size_only, p.threshold = threshold, p.singular_values = kept;
                CAPTURE(by_size_only, threshold, kept);
                const ClusterBound bound = cluster_bound(t.rows(), p), taken = taken_by(make_clusters(t.rows(), p, {}));
                CHECK(taken.matrices <= bound.matrices);
                CHECK(taken.spectrum <= bound.spectrum);
                CHECK(taken.clusters <= bound.clusters);
                // The tree is known, and every matrix has its full rank.
                if (by_size_only || threshold == 0) {
                    CHECK(taken.clusters == bound.clusters);
                    CHECK(taken.spectrum == bound.spectrum);
                }
                if (by_size_only) CHECK(taken.matrices == bound.matrices);
                // Split to its end; of a few cells the parent would have been larger.
                if (threshold == 0 && !by_size_only) CHECK(double(taken.matrices) >= 0.98 * double(bound.matrices));
            }
}

TEST_CASE("clusters: the bound ends for receivers in one point, and for exponentially nearer ones", "[probes][memory][extreme]") {
    Transport t = smooth_transport(200, 5, 4);
    for (glm::vec4& x : t.position) x = glm::vec4(1, 2, 3, 0);
    CHECK(cluster_bound(t.rows(), {}).clusters == 1);
    float x = 1e30f;
    for (glm::vec4& p : t.position) p = glm::vec4(x, 0, 0, 0), x *= 0.5f;
    const ClusterBound b = cluster_bound(t.rows(), {});
    CHECK(b.clusters >= 5);  // of 32 receivers at most
    CHECK(b.clusters <= 200);
}
