#include "gi/probes/lod_reference.h"

#include "gi/probes/bake.h"
#include "gi/probes/run_data.h"

namespace plumb::probes {

std::vector<glm::dvec3> lod_lambda(const Bake& bake, const Lod& lod, const Levels& levels, const std::vector<glm::dvec3>& radiance) {
    const std::size_t rays = std::size_t(bake.relight.rays), all = std::size_t(bake.coefficients());
    std::vector<Buffer<float>> weights;
    for (int k = 0; k < lod.levels; ++k) weights.push_back(relight_weights(bake.relight_directions, lod.rays[std::size_t(k)]));
    std::vector<glm::dvec3> lambda(levels.probe.size() * all, glm::dvec3(0));
    for (std::size_t p = 0; p < levels.probe.size(); ++p) {
        const std::size_t level = std::size_t(levels.probe[p]);
        for (std::size_t r = 0; r < std::size_t(lod.rays[level]); ++r)
            for (std::size_t j = 0; j < std::size_t(lod.coefficients[level]); ++j)
                lambda[p * all + j] += double(weights[level][r]) * double(bake.harmonics[r * all + j]) * radiance[p * rays + r];
    }
    return lambda;
}

std::vector<glm::dvec3> lod_irradiance(const Bake& bake, const Lod& lod, const Levels& levels, const std::vector<glm::dvec3>& lambda) {
    const std::size_t all = std::size_t(bake.coefficients()), kept = std::size_t(bake.clusters.singular_values);
    std::vector<glm::dvec3> irradiance(std::size_t(bake.receivers.count()), glm::dvec3(0));
    const std::vector<std::int32_t> shown = receiver_levels(bake, lod.levels);
    for (std::size_t c = 0; c < bake.clusters.clusters.size(); ++c) {
        const Cluster& cluster = bake.clusters.clusters[c];
        const int level = levels.cluster[c];
        std::vector<glm::dvec3> basis(std::size_t(cluster.rank), glm::dvec3(0));
        for (std::size_t s = 0; s < basis.size(); ++s)
            for (std::size_t p = 0; p < cluster.probes.size(); ++p)
                for (std::size_t j = 0; j < std::size_t(lod.coefficients[std::size_t(level)]); ++j)
                    basis[s] += double(cluster.sigma_vt[(s * cluster.probes.size() + p) * all + j]) *
                                lambda[std::size_t(cluster.probes[p]) * all + j];
        for (const std::int32_t i : cluster.receivers) {
            if (!is_computed(shown[std::size_t(i)], level)) continue;
            for (std::size_t s = 0; s < basis.size(); ++s)
                irradiance[std::size_t(i)] += double(bake.clusters.u[std::size_t(i) * kept + s]) * basis[s];
        }
    }
    return irradiance;
}

}  // namespace plumb::probes
