#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "gi/probes/basis_kernel.h"
#include "gi/probes/bake.h"
#include "gi/probes/lod.h"
#include "gi/probes/sky_probe.h"
#include "gi/probes/run_data.h"

namespace plumb::probes {

namespace {

// Where the surface is: receivers look from beside it where they were moved.
glm::dvec3 on_surface(const Receivers& r, std::size_t i) { return glm::dvec3(r.position[i]) - glm::dvec3(r.shift[i]); }

// The widest step from a receiver to those beside it, and the farthest that one was moved, by clusters, m.
struct Spread {
    std::vector<double> step, moved;
};
Spread spread_of(const Bake& bake) {
    const Receivers& r = bake.receivers;
    Image<std::int32_t> at(r.size.x, r.size.y, -1);
    for (std::size_t i = 0; i < r.texel.size(); ++i) at(r.texel[i].x, r.texel[i].y) = std::int32_t(i);
    // Of a cluster of which no receiver has a neighbour: a texel, seen at the steepest angle that charts have.
    Spread s{std::vector<double>(std::size_t(bake.flat.count()), 2 / bake.atlas.texels_per_m), std::vector<double>(std::size_t(bake.flat.count()), 0.0)};
    std::vector<bool> measured(s.step.size(), false);
    for (std::size_t i = 0; i < r.texel.size(); ++i) {
        const std::int32_t cluster = bake.flat.cluster_of[i];
        if (cluster < 0) continue;
        const std::size_t c = std::size_t(cluster);
        s.moved[c] = std::max(s.moved[c], std::sqrt(glm::dot(glm::dvec3(r.shift[i]), glm::dvec3(r.shift[i]))));
        for (const glm::ivec2& step : border_steps) {
            const glm::ivec2 beside = r.texel[i] + step;
            if (beside.x < 0 || beside.y < 0 || beside.x >= r.size.x || beside.y >= r.size.y || at(beside.x, beside.y) < 0) continue;
            const glm::dvec3 d = on_surface(r, std::size_t(at(beside.x, beside.y))) - on_surface(r, i);
            const double length = std::sqrt(glm::dot(d, d));
            s.step[c] = measured[c] ? std::max(s.step[c], length) : length;
            measured[c] = true;
        }
    }
    return s;
}

void add_box(Buffer<glm::vec4>& low, Buffer<glm::vec4>& high, const glm::vec3& a, const glm::vec3& b, float margin) {
    low.push_back(glm::vec4(a, margin)), high.push_back(glm::vec4(b, 0));
}

// A thousandth more than needed, for what rounding may do far away.
float margin_of(double m) { return float(1.001 * m); }

std::vector<std::int32_t> levels_of(const Buffer<glm::vec4>& low, const Buffer<glm::vec4>& high, const LevelRule& rule,
                                    const RunOptions& options) {
    std::vector<std::int32_t> levels;
    run(LevelInputs{&low, &high, rule}, options, levels);
    return levels;
}

// Makes each probe as fine as the finest of these clusters that reads it.
void refine_by_clusters(const FlatClusters& flat, const std::vector<std::int32_t>& cluster_levels, std::vector<std::int32_t>& of) {
    for (std::size_t c = 0; c < cluster_levels.size(); ++c)
        for (std::int32_t k = flat.first_probe[c]; k < flat.first_probe[c + 1]; ++k) {
            std::int32_t& level = of[std::size_t(flat.probes[std::size_t(k)])];
            level = std::min(level, cluster_levels[c]);
        }
}

}  // namespace

Lod lod_of(const LodParams& params, const Bake& bake) {
    glm::vec3 low, high;
    if (!bounds(bake.atlas.geometry, low, high)) throw InputError("lod: the scene has no surfaces");
    const glm::dvec3 size = glm::dvec3(high) - glm::dvec3(low);
    return lod_of(params, std::sqrt(glm::dot(size, size)), bake.params.degree, bake.params.relight_rays, bake.params.gap);
}

LodBoxes lod_boxes(const Bake& bake, Unasked unasked) {
    LodBoxes boxes;
    const Spread spread = spread_of(bake);
    for (int c = 0; c < bake.flat.count(); ++c) {
        const float* b = bake.flat.box.data() + 6 * std::ptrdiff_t(c);
        const double reach = lookup_reach * std::sqrt(2.0) * spread.step[std::size_t(c)] + spread.moved[std::size_t(c)];
        add_box(boxes.cluster_low, boxes.cluster_high, {b[0], b[1], b[2]}, {b[3], b[4], b[5]}, margin_of(reach));
    }
    for (const glm::vec4& p : bake.placement.probes)
        add_box(boxes.probe_low, boxes.probe_high, glm::vec3(p), glm::vec3(p), margin_of(bake.radius.radius_m));
    const std::vector<std::int32_t> ray_of = stand_ins(bake, unasked, {});
    for (std::size_t k = 0; k < bake.relight.position.size(); ++k) {
        const glm::vec4 p = bake.relight.position[std::size_t(ray_of[k])];
        const glm::vec4 probe = bake.placement.probes[k / std::size_t(bake.relight.rays)];
        boxes.hit.push_back(glm::vec4(glm::vec3(p.w > 0 ? p : probe), 0));
    }
    return boxes;
}

Levels levels_at(const Lod& lod, const Bake& bake, const LodBoxes& boxes, const glm::vec3& eye, const glm::vec3& forward,
                 const RunOptions& options, const AirReads& reads) {
    Levels of;
    if (lod.off()) {
        of.cluster.assign(boxes.cluster_low.size(), 0), of.probe.assign(boxes.probe_low.size(), 0);
        return of;
    }
    LevelRule rule = rule_at(lod, eye, forward);
    of.cluster = levels_of(boxes.cluster_low, boxes.cluster_high, rule, options);
    if (lod.hit_level == HitLevel::coarsest)
        of.hit.assign(boxes.hit.size(), lod.levels - 1);
    else
        of.hit = levels_of(boxes.hit, boxes.hit, rule, options);
    if (!reads.cell.empty())
        of.air = air_levels(bake.spatial.grid, reads, levels_of(reads.low, reads.high, rule, options), bake.spatial.flat.cluster_of, bake.spatial.flat.count());
    if (lod.probe_level == ProbeLevel::clusters) {
        of.probe.assign(bake.placement.probes.size(), lod.levels - 1);  // of a probe that none reads
        refine_by_clusters(bake.flat, of.cluster, of.probe), refine_by_clusters(bake.spatial.flat, of.air.cluster, of.probe);
    } else {
        rule.margins = glm::vec4(lod.probe_level == ProbeLevel::radius ? 1 : 0);
        of.probe = levels_of(boxes.probe_low, boxes.probe_high, rule, options);
        if (standing_probes(bake.placement.probes) < int(of.probe.size())) of.probe.back() = 0;  // the sky: clusters of all levels ask it
    }
    return of;
}

namespace {

// Clusters and receivers. computed(receiver, level of its cluster).
template <class Computed>
void count_clusters(const Lod& lod, const FlatClusters& flat, const std::vector<std::int32_t>& levels, Computed computed, LodCounts& n) {
    for (std::size_t c = 0; c < levels.size(); ++c) {
        const int level = levels[c], rank = flat.rank[c];
        if (level >= lod.levels) continue;
        ++n.clusters[std::size_t(level)];
        const std::int64_t probes = flat.first_probe[c + 1] - flat.first_probe[c];
        n.basis_terms += probes * lod.coefficients[std::size_t(level)] * rank;
        for (std::int32_t i = flat.first_receiver[c]; i < flat.first_receiver[c + 1]; ++i) {
            if (!computed(std::size_t(flat.receivers[std::size_t(i)]), level)) continue;
            ++n.receivers;
            n.irradiance_terms += rank;
        }
    }
    // Radiance of each ray, a matrix and a row of U for each term, an irradiance for each receiver.
    n.bytes = 16 * n.rays + 4 * (n.basis_terms + n.irradiance_terms) + 16 * n.receivers;
}

}  // namespace

LodCounts lod_counts(const Lod& lod, const Bake& bake, const Levels& levels) {
    LodCounts n;
    const std::vector<std::int32_t> shown = receiver_levels(bake, lod.levels);
    for (const std::int32_t level : levels.probe) {
        const std::size_t k = std::size_t(level);
        ++n.probes[k];
        n.rays += lod.rays[k];
        n.lambda_terms += std::int64_t(lod.rays[k]) * lod.coefficients[k];
    }
    count_clusters(lod, bake.flat, levels.cluster, [&](std::size_t i, int level) { return is_computed(shown[i], level); }, n);
    return n;
}

LodCounts air_counts(const Lod& lod, const Bake& bake, const AirLevels& levels) {
    LodCounts n;
    count_clusters(lod, bake.spatial.flat, levels.cluster, [&](std::size_t i, int) { return levels.place[i % levels.place.size()] != no_level; }, n);
    return n;
}

std::array<int, most_levels> charts_missing(const Bake& bake, int levels) {
    const std::size_t charts = bake.atlas.charts.size();
    std::vector<int> most(charts, -1);
    const std::vector<std::int32_t> shown = receiver_levels(bake, levels);
    for (int i = 0; i < bake.receivers.count(); ++i) {
        const std::int32_t chart = bake.atlas.chart[std::size_t(bake.receivers.triangle[std::size_t(i)])];
        if (chart < 0) continue;
        int& level = most[std::size_t(chart)];
        level = std::max(level, shown[std::size_t(i)]);
    }
    std::array<int, most_levels> missing{};
    for (int k = 0; k < levels; ++k)
        missing[std::size_t(k)] = int(std::count_if(most.begin(), most.end(), [&](int level) { return level < k; }));
    return missing;
}

}  // namespace plumb::probes
