#include "gi/probes/run_data.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "core/error.h"
#include "gi/probes/bake.h"
#include "gi/probes/textures.h"

namespace plumb::probes {

namespace {

std::int32_t index_of(std::size_t n, const char* what) {
    if (n > std::size_t(std::numeric_limits<std::int32_t>::max()))
        throw InputError(fmt::format("run time: {} {}: more than an index of 31 bits reaches", n, what));
    return std::int32_t(n);
}

void check(const FlatClusters& f, int receivers, int coefficients) {
    const std::size_t n = f.rank.size(), count = std::size_t(receivers);
    std::size_t numbers = 0;
    bool fits = f.first_receiver.size() == n + 1 && f.first_probe.size() == n + 1 && f.cluster_of.size() == count &&
                f.u.size() == count * std::size_t(f.singular_values) && std::size_t(f.first_receiver.back()) == f.receivers.size() &&
                std::size_t(f.first_probe.back()) == f.probes.size();
    for (std::size_t c = 0; c < n && fits; ++c) {
        fits = f.rank[c] >= 0 && f.rank[c] <= f.singular_values && f.first_receiver[c] <= f.first_receiver[c + 1] &&
               f.first_probe[c] <= f.first_probe[c + 1];
        numbers += std::size_t(f.rank[c]) * std::size_t(f.first_probe[c + 1] - f.first_probe[c]) * std::size_t(coefficients);
    }
    std::vector<std::uint8_t> seen(count, 0);
    for (std::size_t k = 0; k < f.receivers.size() && fits; ++k) {
        const std::int32_t i = f.receivers[k];
        fits = i >= 0 && i < receivers && !seen[std::size_t(i)];
        if (fits) seen[std::size_t(i)] = 1;
    }
    if (!fits || numbers != f.sigma_vt.size()) throw InputError("run time: clusters do not fit the receivers, or their lists each other");
}

// Sigma V^T of all clusters, each turned around.
Buffer<float> turned(const FlatClusters& f, int coefficients) {
    Buffer<float> out(f.sigma_vt.size());
    std::size_t first = 0;
    for (std::size_t c = 0; c < f.rank.size(); ++c) {
        const std::size_t rank = std::size_t(f.rank[c]);
        const std::size_t columns = std::size_t(f.first_probe[c + 1] - f.first_probe[c]) * std::size_t(coefficients);
        for (std::size_t s = 0; s < rank; ++s)
            for (std::size_t k = 0; k < columns; ++k) out[first + k * rank + s] = f.sigma_vt[first + s * columns + k];
        first += rank * columns;
    }
    return out;
}

// Cluster by cluster, coarse levels first, then those without.
void order_places(const FlatClusters& f, int receivers, const std::vector<std::int32_t>& level, ClusterData& d) {
    d.receiver = f.receivers;
    d.receiver.reserve(std::size_t(receivers)), d.cluster.reserve(std::size_t(receivers));
    for (std::size_t c = 0; c < f.rank.size(); ++c) {
        d.cluster.resize(std::size_t(f.first_receiver[c + 1]), std::int32_t(c));
        if (!level.empty())
            std::stable_sort(d.receiver.begin() + f.first_receiver[c], d.receiver.begin() + f.first_receiver[c + 1],
                             [&](std::int32_t a, std::int32_t b) { return level[std::size_t(a)] > level[std::size_t(b)]; });
    }
    d.place_of.assign(std::size_t(receivers), -1);
    for (std::size_t i = 0; i < d.receiver.size(); ++i) d.place_of[std::size_t(d.receiver[i])] = std::int32_t(i);
    for (std::int32_t i = 0; i < receivers; ++i)
        if (std::int32_t& place = d.place_of[std::size_t(i)]; place < 0) place = std::int32_t(d.receiver.size()), d.receiver.push_back(i);
    d.cluster.resize(std::size_t(receivers), -1);
}

std::vector<std::int32_t> levels_of(const std::vector<glm::ivec2>& texels, int levels) {
    std::vector<std::int32_t> level;
    level.reserve(texels.size());
    for (const glm::ivec2& t : texels) level.push_back(level_of_texel(t, levels));
    return level;
}

RunData laid_out(const FlatClusters& flat, int coefficients, const std::vector<glm::ivec2>& texels, int side, int levels,
                 const std::vector<std::int32_t>& level) {
    RunData d;
    static_cast<ClusterData&>(d) = cluster_data(flat, int(texels.size()), coefficients, level);
    d.levels = levels;
    d.cover = lightmap_cover(texels, d.place_of, side, levels, level);
    d.lightmap_size = {d.cover.width, d.cover.height};
    d.receiver_level.reserve(d.receiver.size());
    for (const std::int32_t i : d.receiver) d.receiver_level.push_back(level[std::size_t(i)]);
    d.coarsest.assign(d.clusters.size(), -1);
    for (std::size_t i = 0; i < d.receiver.size(); ++i)
        if (d.cluster[i] >= 0) d.coarsest[std::size_t(d.cluster[i])] = std::max(d.coarsest[std::size_t(d.cluster[i])], d.receiver_level[i]);
    return d;
}

// As much of FlatClusters as cluster_data() reads.
FlatClusters flat_of(const BakeArrays& a) {
    FlatClusters f;
    f.singular_values = a.singular_values;
    std::vector<std::vector<std::int32_t>> receivers(a.clusters.size());
    for (std::size_t i = 0; i < a.receivers.size(); ++i) {
        f.cluster_of.push_back(a.receivers[i].cluster);
        if (a.receivers[i].cluster >= 0) receivers.at(std::size_t(a.receivers[i].cluster)).push_back(std::int32_t(i));
    }
    for (std::size_t c = 0; c < a.clusters.size(); ++c) {
        const BakedCluster& cluster = a.clusters[c];
        f.receivers.insert(f.receivers.end(), receivers[c].begin(), receivers[c].end());
        f.probes.insert(f.probes.end(), cluster.probes.begin(), cluster.probes.end());
        f.sigma_vt.insert(f.sigma_vt.end(), cluster.sigma_vt.begin(), cluster.sigma_vt.end());
        f.first_receiver.push_back(std::int32_t(f.receivers.size())), f.first_probe.push_back(std::int32_t(f.probes.size()));
        f.rank.push_back(cluster.rank);
    }
    f.u.assign(a.u.begin(), a.u.end());
    return f;
}

}  // namespace

ClusterData cluster_data(const FlatClusters& f, int receivers, int coefficients, const std::vector<std::int32_t>& level) {
    check(f, receivers, coefficients);
    if (!level.empty() && level.size() != std::size_t(receivers)) throw InputError("run time: levels of detail are not one a receiver");
    ClusterData d;
    d.coefficients = coefficients, d.singular_values = f.singular_values;
    (void)index_of(f.u.size(), "numbers of U");
    std::size_t first = 0;
    for (std::size_t c = 0; c < f.rank.size(); ++c) {
        const std::int32_t probes = f.first_probe[c + 1] - f.first_probe[c];
        d.clusters.push_back({index_of(first, "numbers of clusters"), f.first_probe[c], probes, f.rank[c]});
        first += std::size_t(f.rank[c]) * std::size_t(probes) * std::size_t(coefficients);
    }
    (void)index_of(first, "numbers of clusters");
    d.cluster_probes = f.probes;
    d.matrix = turned(f, coefficients);
    order_places(f, receivers, level, d);
    d.u.resize(f.u.size());
    const std::size_t places = d.receiver.size(), kept = std::size_t(f.singular_values);
    for (std::size_t i = 0; i < places; ++i)
        for (std::size_t s = 0; s < kept; ++s) d.u[s * places + i] = f.u[std::size_t(d.receiver[i]) * kept + s];
    return d;
}

RunData run_data(const Bake& bake, int levels) {
    const glm::ivec2 size = bake.receivers.size;
    if (size.x != size.y) throw InputError(fmt::format("run time: a lightmap of {} x {}: expected a square", size.x, size.y));
    const std::vector<std::int32_t> level = receiver_levels(bake, levels);
    RunData d = laid_out(bake.flat, bake.coefficients(), bake.receivers.texel, size.x, levels, level);
    d.probes = bake.relight.probes, d.rays = int(bake.relight_directions.size());
    d.tiles = lightmap_tiles(bake, levels, bake.flat.cluster_of, level);
    return d;
}

RunData run_data(const BakeArrays& arrays, int side, int levels) {
    std::vector<glm::ivec2> texels;
    for (const BakedReceiver& r : arrays.receivers) texels.push_back(r.texel);
    RunData d = laid_out(flat_of(arrays), arrays.coefficients, texels, side, levels, levels_of(texels, levels));
    d.probes = int(arrays.probes.size()), d.rays = arrays.rays;
    return d;
}

std::vector<std::int32_t> basis_levels(const RunData& data, const std::vector<std::int32_t>& cluster_level) {
    std::vector<std::int32_t> level = cluster_level;
    for (std::size_t c = 0; c < level.size(); ++c)
        if (data.coarsest[c] < level[c]) level[c] = -1;
    return level;
}

// ---- The lightmap's levels --------------------------------------------------------------------------------------------

int level_of_texel(glm::ivec2 texel, int levels) {
    int level = 0;
    while (level < levels - 1 && (((texel.x | texel.y) >> level) & 1) == 0) ++level;
    return level;
}

namespace {

using Level = LightmapLevel<float>;

// Texels of the level with nothing, beside one that `is_source` says yes of, become `ring`.
template <class IsSource>
void mark_ring(Image<std::int32_t>& cover, const Level& level, Cover ring, IsSource is_source) {
    const auto beside_source = [&](int x, int y) {
        for (int ny = std::max(y - 1, 0); ny <= std::min(y + 1, level.side - 1); ++ny)
            for (int nx = std::max(x - 1, 0); nx <= std::min(x + 1, level.side - 1); ++nx)
                if (is_source(cover(nx, level.first + ny))) return true;
        return false;
    };
    for (int y = 0; y < level.side; ++y)
        for (int x = 0; x < level.side; ++x)
            if (std::int32_t& c = cover(x, level.first + y); c == cover_nothing && beside_source(x, y)) c = ring;
}

}  // namespace

std::vector<std::int32_t> receiver_levels(const Bake& bake, int levels) {
    const std::vector<glm::ivec2>& texels = bake.receivers.texel;
    std::vector<std::int32_t> level = levels_of(texels, levels);
    const auto chart_of = [&](std::size_t i) { return std::size_t(std::max(0, bake.atlas.chart[std::size_t(bake.receivers.triangle[i])])); };
    std::size_t charts = 1;
    for (std::size_t i = 0; i < texels.size(); ++i) charts = std::max(charts, chart_of(i) + 1);
    for (int k = 1; k < levels; ++k) {
        const int side = ((bake.receivers.size.x - 1) >> k) + 1;
        Image<std::uint8_t> taken(side, side, 0);
        std::vector<std::uint8_t> shown(charts, 0);
        for (std::size_t i = 0; i < texels.size(); ++i)
            if (level[i] >= k) taken(texels[i].x >> k, texels[i].y >> k) = 1, shown[chart_of(i)] = 1;
        for (std::size_t i = 0; i < texels.size(); ++i) {
            std::uint8_t& texel = taken(texels[i].x >> k, texels[i].y >> k);
            if (!shown[chart_of(i)] && level[i] == k - 1 && texel == 0) level[i] = k, texel = 1;
        }
    }
    return level;
}

Image<std::int32_t> lightmap_cover(const std::vector<glm::ivec2>& texels, const std::vector<std::int32_t>& place_of, int side,
                                   int levels) {
    return lightmap_cover(texels, place_of, side, levels, levels_of(texels, levels));
}

Image<std::int32_t> lightmap_cover(const std::vector<glm::ivec2>& texels, const std::vector<std::int32_t>& place_of, int side, int levels,
                                   const std::vector<std::int32_t>& receiver_level) {
    if (levels < 1 || levels > most_levels)
        throw InputError(fmt::format("run time: {} levels of detail: expected 1 to {}", levels, most_levels));
    Image<std::int32_t> cover(side, lightmap_rows(side, levels), cover_nothing);
    std::vector<Level> of;
    for (int k = 0; k < levels; ++k) of.push_back(lightmap_level<float>(side, levels, k));
    for (std::size_t i = 0; i < texels.size(); ++i) {
        const glm::ivec2 t = texels[i];
        if (t.x < 0 || t.y < 0 || t.x >= side || t.y >= side)
            throw InputError(fmt::format("run time: receiver {} at texel {}, {} of a lightmap of {} x {}", i, t.x, t.y, side, side));
        if (cover(t.x, t.y) != cover_nothing)
            throw InputError(fmt::format("run time: two receivers at texel {}, {} of the lightmap", t.x, t.y));
        for (int k = 0; k <= receiver_level[i]; ++k) cover(t.x >> k, of[std::size_t(k)].first + (t.y >> k)) = place_of.at(i);
    }
    for (const Level& level : of) {
        mark_ring(cover, level, cover_ring_1, [](std::int32_t c) { return c >= 0; });
        mark_ring(cover, level, cover_ring_2, [](std::int32_t c) { return c == cover_ring_1; });
    }
    return cover;
}

}  // namespace plumb::probes
