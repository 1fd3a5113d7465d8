// What of a scene is baked: its static meshes. Those that move (Mesh::dynamic) block no ray, have no receivers and no probes near
// them; the run time lights them by the spatial receivers.
#pragma once

#include <cstdint>
#include <vector>

#include "core/scene.h"
#include "raster/surfaces.h"

namespace plumb::probes {

// flatten() of the scene without its dynamic meshes: Geometry::object counts static meshes alone. Throws InputError where every
// mesh is dynamic.
Geometry flatten_static(const Scene& scene);

// scene_hash() of it (bake.h). What was asked last is kept by the meshes' own content: each frame of a walk asks whether a bake is of
// its scene.
std::uint64_t scene_hash(const Scene& scene);

// Surfaces as if no material had a normal map. A lightmap's texels are coarser than a normal map: receivers have the normals without.
void drop_normal_maps(raster::Surfaces& surfaces);

// Of each triangle of flatten(scene): its index in flatten_static(scene), which is that of a bake's atlas; -1 of dynamic meshes.
std::vector<std::int32_t> static_triangles(const Scene& scene, const Geometry& geometry);

}  // namespace plumb::probes
