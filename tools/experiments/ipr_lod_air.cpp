// plumb experiment ipr, level of detail: what moves, lit by spatial receivers with levels (gi/probes/lod_air.h).
#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/error.h"
#include "gi/probes/basis_kernel.h"
#include "gi/probes/volume.h"
#include "tools/experiments/ipr_lod_world.h"

namespace plumb::cli {

namespace {

constexpr std::size_t most_points = 8192;  // of vertices, every k-th

// Of all that reads the air, as it is without levels.
probes::AirLevels without_levels(const probes::SpatialGrid& grid, const std::vector<std::uint8_t>& active, const std::vector<std::int32_t>& cluster_of, int clusters) {
    probes::AirLevels all{std::vector<std::int32_t>(std::size_t(grid.places()), probes::no_level), std::vector<std::int32_t>(std::size_t(clusters), probes::no_level)};
    for (std::size_t i = 0; i < active.size(); ++i)
        if (active[i]) all.place[i] = 0;
    for (std::size_t r = 0; r < cluster_of.size(); ++r)
        if (cluster_of[r] >= 0 && active[r % active.size()]) all.cluster[std::size_t(cluster_of[r])] = 0;
    return all;
}

}  // namespace

Scene still_scene(const Scene& scene) {
    Scene still = scene;
    std::erase_if(still.meshes, [](const Mesh& m) { return m.dynamic; });
    return still;
}

void LodBench::World::take_moving(const Scene& of) {
    moving = probes::dynamic_boxes(of);
    air = probes::cluster_data(bake.spatial.flat, bake.spatial.receivers.count(), bake.coefficients());
    std::vector<glm::vec4> position, normal;
    for (const Mesh& m : of.meshes) {
        if (!m.dynamic) continue;
        const glm::dmat3 turn(m.transform);
        for (const Vertex& v : m.vertices) {
            const glm::dvec3 n = turn * glm::dvec3(v.normal);
            const double length = std::sqrt(glm::dot(n, n));
            if (!(length > 0)) continue;
            position.push_back(glm::vec4(glm::vec3(m.transform * glm::dvec4(glm::dvec3(v.position), 1)), 0));
            normal.push_back(glm::vec4(glm::vec3(n / length), 1));
        }
    }
    if (position.empty()) return moving.clear();
    const std::size_t step = (position.size() + most_points - 1) / most_points, count = (position.size() + step - 1) / step;
    air_position = air_normal = Image4(int(count), 1);
    for (std::size_t i = 0; i < count; ++i) air_position.texels[i] = position[i * step], air_normal.texels[i] = normal[i * step];
}

LodAir LodBench::World::in_the_air(LodRun& run, int times, Image4& light, const Image4& reference) const {
    const probes::Spatial& s = bake.spatial;
    LodAir m;
    const std::vector<std::uint8_t> read = probes::active_places(s.grid, moving);
    m.read = std::count(read.begin(), read.end(), 1);
    const probes::AirLevels levels = run.lod.off() ? without_levels(s.grid, read, s.flat.cluster_of, s.flat.count()) : run.levels.air;
    std::vector<std::uint8_t> computed;
    for (const std::int32_t level : levels.place) computed.push_back(level != probes::no_level ? 1 : 0);
    m.computed = std::count(computed.begin(), computed.end(), 1);
    m.counts = probes::air_counts(run.lod, bake, levels);
    const std::vector<std::int32_t> shown = probes::active_levels(s.grid, computed, air.receiver, run.lod.levels - 1);
    probes::BasisInputs basis = probes::basis_inputs(buffers(run));
    basis.clusters = &air, basis.cluster_level = levels.cluster.data(), basis.lambda = run.lambda.data();
    Buffer<glm::vec4> of_clusters, of_places, grid;
    m.ms = lod_median_ms([&] {
        probes::run(basis, options, of_clusters);
        probes::run(probes::IrradianceInputs{&air, levels.cluster.data(), shown.data(), of_clusters.data()}, options, of_places);
        probes::gather_grid(s.grid, air.receiver, of_places, grid);
        probes::fill_air(s.grid, levels.place, grid);
    }, times);
    const Image4 no_lightmap(air_position.width, 1, glm::vec4(-1));
    probes::VolumeInputs in;
    in.grid = s.grid, in.position = &air_position, in.normal = &air_normal, in.lightmap_uv = &no_lightmap, in.irradiance = &grid;
    probes::VolumeLight found;
    probes::run(in, options, found);
    light = std::move(found.irradiance);
    const Image4& beside = reference.empty() ? light : reference;
    double sum = 0, difference = 0, worst = 0, least = HUGE_VAL;
    for (std::size_t i = 0; i < light.size(); ++i) {
        const double e = lod_luminance(light.texels[i]), d = std::fabs(e - lod_luminance(beside.texels[i]));
        sum += lod_luminance(beside.texels[i]), difference += d, worst = std::max(worst, d), least = std::min(least, e);
    }
    if (!(sum > 0)) throw InputError("level of detail: no light reaches what moves");
    const double mean = sum / double(light.size());
    m.error = difference / sum, m.worst = worst / mean, m.least = least / mean;
    return m;
}

}  // namespace plumb::cli
