#include "gi/probes/relight.h"

#include "core/parallel.h"
#include "gi/probes/receiver_rays_kernel.h"
#include "gi/probes/sky_probe.h"

namespace plumb::probes {

namespace {

// The hits of one probe. A probe's rays are few beside the receivers': one lane at a time.
void trace_probe(const Atlas& atlas, const raster::SurfaceArgs& surfaces, const RayQuery& query, const glm::vec3& probe,
                 const Buffer<glm::vec4>& directions, std::size_t first, RelightHits& hits) {
    RayTracer<float> tracer(query);
    if (is_sky(glm::vec4(probe, 0))) {
        for (std::size_t k = 0; k < directions.size(); ++k) hits.position[first + k] = glm::vec4(glm::vec3(directions[k]), 0);
        return;
    }
    for (std::size_t k = 0; k < directions.size(); ++k) {
        const glm::vec3 direction(directions[k]);
        const RayHit<float> hit = tracer.nearest(probe, direction, true);
        const std::size_t at = first + k;
        if (!hit.found) {
            hits.position[at] = glm::vec4(direction, 0);
            continue;
        }
        const Met<float> met = met_by<float>(surfaces, hit, direction);
        const glm::uvec3 corner = atlas.geometry.triangles[std::size_t(hit.triangle)];
        const glm::dvec2 a(atlas.uv[corner.x]), b(atlas.uv[corner.y]), c(atlas.uv[corner.z]), l(hit.barycentrics);
        hits.triangle[at] = hit.triangle;
        hits.material[at] = met.front ? atlas.geometry.material[std::size_t(hit.triangle)] : met_back;
        hits.uv[at] = glm::vec2(a + l.x * (b - a) + l.y * (c - a));
        hits.position[at] = glm::vec4(met.point, 1);
    }
}

}  // namespace

RelightHits no_hits(int probes, int rays) {
    RelightHits hits;
    hits.probes = probes, hits.rays = rays;
    const std::size_t n = std::size_t(probes) * std::size_t(rays);
    hits.material.assign(n, met_nothing), hits.triangle.assign(n, -1);
    hits.uv.assign(n, glm::vec2(0)), hits.position.assign(n, glm::vec4(0));
    return hits;
}

void relight_rays(const Atlas& atlas, const raster::SurfaceArgs& surfaces, const RayQuery& query,
                  const Buffer<glm::vec4>& probes, const Buffer<glm::vec4>& directions, int first, int count,
                  const RunOptions& options, RelightHits& hits) {
    parallel_bands(count, 1, options, [&](int begin, int end) {
        for (int p = first + begin; p < first + end; ++p)
            trace_probe(atlas, surfaces, query, glm::vec3(probes[std::size_t(p)]), directions,
                        std::size_t(p) * directions.size(), hits);
    });
}

RelightHits relight_rays(const Atlas& atlas, const raster::SurfaceArgs& surfaces, const RayQuery& query,
                         const Buffer<glm::vec4>& probes, const Buffer<glm::vec4>& directions, const RunOptions& options) {
    RelightHits hits = no_hits(int(probes.size()), int(directions.size()));
    relight_rays(atlas, surfaces, query, probes, directions, 0, hits.probes, options, hits);
    return hits;
}

}  // namespace plumb::probes
