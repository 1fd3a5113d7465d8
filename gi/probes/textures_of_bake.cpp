#include "gi/probes/bake.h"
#include "gi/probes/textures.h"

namespace plumb::probes {

BakeArrays arrays_of(const Bake& b) {
    BakeArrays a;
    a.rays = b.relight.rays, a.coefficients = b.coefficients(), a.singular_values = b.clusters.singular_values;
    for (int i = 0; i < b.receivers.count(); ++i)
        a.receivers.push_back({glm::vec3(b.receivers.position[std::size_t(i)]), b.receivers.texel[std::size_t(i)],
                               b.receivers.material[std::size_t(i)], b.receivers.border[std::size_t(i)],
                               b.clusters.cluster_of[std::size_t(i)]});
    a.u.assign(b.clusters.u.begin(), b.clusters.u.end());
    for (const glm::vec4& p : b.placement.probes) a.probes.push_back(glm::vec3(p));
    for (std::size_t i = 0; i < b.relight.material.size(); ++i)
        a.relight.push_back({b.relight.material[i], b.relight.uv[i], glm::vec3(b.relight.position[i])});
    a.sh.assign(b.harmonics.begin(), b.harmonics.end());
    for (const Cluster& c : b.clusters.clusters) a.clusters.push_back({c.probes, c.rank, c.sigma_vt, c.low, c.high});
    return a;
}

}  // namespace plumb::probes
