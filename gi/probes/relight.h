// Relight rays: where each probe looks for radiance, once and for all (IPR 3.2.3.1).
#pragma once

#include "core/isa.h"
#include "core/ray_query.h"
#include "gi/probes/atlas.h"
#include "raster/surface_kernel.h"

namespace plumb::probes {

// RelightHits::material of rays that meet no surface of which a radiance is known.
inline constexpr std::int32_t met_nothing = -1;  // the environment is seen
inline constexpr std::int32_t met_back = -2;     // the back of a surface: black

struct RelightHits {
    int probes = 0, rays = 0;
    std::vector<std::int32_t> material;  // [probes][rays]: index into Scene::materials, met_nothing or met_back
    std::vector<std::int32_t> triangle;  // [probes][rays]: of Atlas::geometry; -1: none
    Buffer<glm::vec2> uv;                // [probes][rays]: of the lightmap, (0, 0) the top left corner of the first texel
    Buffer<glm::vec4> position;          // [probes][rays]: xyz m, w 1; or the direction, w 0
};

// Of rays that have not been traced: all meet nothing.
RelightHits no_hits(int probes, int rays);

// Traces the rays of probes [first, first + count).
void relight_rays(const Atlas& atlas, const raster::SurfaceArgs& surfaces, const RayQuery& query,
                  const Buffer<glm::vec4>& probes, const Buffer<glm::vec4>& directions, int first, int count,
                  const RunOptions& options, RelightHits& hits);
// Of all probes.
RelightHits relight_rays(const Atlas& atlas, const raster::SurfaceArgs& surfaces, const RayQuery& query,
                         const Buffer<glm::vec4>& probes, const Buffer<glm::vec4>& directions, const RunOptions& options);

}  // namespace plumb::probes
