// Clusters of any size and rank, coefficients of probes and covers of lightmaps, from numbers: what the run time of probes reads.
#pragma once

#include <algorithm>
#include <numeric>
#include <vector>

#include "gi/probes/run_data.h"
#include "tests/parity/twin_data_parts.h"

namespace plumb::test {

struct MadeCluster {
    int receivers, probes, rank;
};

// Receivers of all clusters, and `without` in none, in an order that mixes them; the cluster's probes are neighbours in theirs.
// Numbers lie in -1 .. 1.
inline probes::FlatClusters made_clusters(const std::vector<MadeCluster>& clusters, int probes, int coefficients, int singular_values,
                                          int without, std::uint32_t seed) {
    probes::FlatClusters f;
    f.singular_values = singular_values;
    for (std::size_t c = 0; c < clusters.size(); ++c) f.cluster_of.insert(f.cluster_of.end(), std::size_t(clusters[c].receivers), int(c));
    f.cluster_of.insert(f.cluster_of.end(), std::size_t(without), -1);
    std::vector<int> order(f.cluster_of.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return noise(a, 1, 0, seed) < noise(b, 1, 0, seed); });
    std::vector<std::int32_t> mixed;
    for (const int i : order) mixed.push_back(f.cluster_of[std::size_t(i)]);
    f.cluster_of = mixed;
    const auto number = [&](int i, int channel) { return 2 * noise(i, 2, channel, seed) - 1; };
    for (std::size_t c = 0; c < clusters.size(); ++c) {
        const MadeCluster& made = clusters[c];
        for (std::size_t i = 0; i < f.cluster_of.size(); ++i)
            if (f.cluster_of[i] == std::int32_t(c)) f.receivers.push_back(std::int32_t(i));
        std::vector<std::int32_t> own;
        for (int k = 0; k < made.probes; ++k) own.push_back(std::int32_t((7 * c + std::size_t(k)) % std::size_t(probes)));
        std::sort(own.begin(), own.end());
        f.probes.insert(f.probes.end(), own.begin(), own.end());
        f.first_receiver.push_back(std::int32_t(f.receivers.size())), f.first_probe.push_back(std::int32_t(f.probes.size()));
        f.rank.push_back(made.rank);
        const int numbers = made.rank * made.probes * coefficients;
        for (int k = 0; k < numbers; ++k) f.sigma_vt.push_back(number(k, int(c)));
    }
    for (std::size_t i = 0; i < f.cluster_of.size(); ++i)
        for (int s = 0; s < singular_values; ++s) {
            const std::int32_t c = f.cluster_of[i];
            f.u.push_back(c >= 0 && s < clusters[std::size_t(c)].rank ? number(int(i), 1000 + s) : 0.0f);
        }
    return f;
}

// Light from everywhere: the first coefficient of a probe is the largest.
inline Buffer<glm::vec4> made_lambda(int probes, int coefficients, std::uint32_t seed) {
    Buffer<glm::vec4> lambda;
    for (int p = 0; p < probes; ++p)
        for (int j = 0; j < coefficients; ++j) {
            const float base = j == 0 ? 3.0f : 0.0f;
            lambda.push_back({base + noise(p, j, 0, seed) - 0.5f, base + noise(p, j, 1, seed) - 0.5f, base + noise(p, j, 2, seed) - 0.5f, 0});
        }
    return lambda;
}

// Texels of a lightmap in which about that share are receivers, in the order of rows.
inline std::vector<glm::ivec2> made_texels(int side, float share, std::uint32_t seed) {
    std::vector<glm::ivec2> texels;
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x)
            // Patches of 4 x 4, so that there are insides, edges and gaps; and single texels.
            if (noise(x / 4, y / 4, 7, seed) < share || noise(x, y, 8, seed) < 0.02f) texels.push_back({x, y});
    return texels;
}

}  // namespace plumb::test
