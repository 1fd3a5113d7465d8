// Indirect shadows of dynamic meshes by rays against the meshes themselves: what probes.indirect_shadow approximates by spheres, of the
// same light. Host only: rays.
#pragma once

#include <memory>

#include "core/image.h"
#include "core/isa.h"
#include "core/ray_query.h"
#include "core/scene.h"
#include "core/stage.h"
#include "gi/probes/spatial.h"
#include "raster/surfaces.h"

namespace plumb::probes {

// The dynamic meshes of a scene alone. Holds pointers into itself: made once, in place.
struct DynamicWorld {
    Geometry geometry;
    raster::Surfaces surfaces;
    std::unique_ptr<RayQuery> query;  // null: nothing moves
    float offset = 0;                 // m, off surfaces: of the whole scene

    DynamicWorld() = default;
    DynamicWorld(const DynamicWorld&) = delete;
    DynamicWorld& operator=(const DynamicWorld&) = delete;
};
// whole: flatten(scene).
std::unique_ptr<DynamicWorld> dynamic_world(const Scene& scene, const Geometry& whole);

struct Bake;
struct HitSurfaces;

struct ShadowRaysInputs {
    const DynamicWorld* world = nullptr;
    int rays = 64;                                  // of a point
    const Image4* position = nullptr;               // xyz m
    const Image4* normal = nullptr;                 // xyz unit; w 1: a point
    const Image4* irradiance = nullptr;             // E, W/m2
    const SpatialGrid* grid = nullptr;              // null: light comes from everywhere alike
    const Buffer<glm::vec4>* six = nullptr;         // [place][direction] W/m2
};
// E' = max(0, E - pi / N sum over rays that meet a mesh of max(0, a + b . w)), a + b . w of the grid where it is met (light_spheres());
// without a grid E' = E (1 - hits / N). w as of E. N directions distributed as the cosine (Hammersley), turned about the normal by one
// of 16 angles, as pixels lie in squares of 4 x 4. A mesh shades itself, too.
void run(const ShadowRaysInputs& in, const RunOptions& options, Image4& shaded);

// Relight rays that meet a dynamic mesh before what stands still end there: position, normal, reflectance and emission are the mesh's, and
// black where a ray meets its back. Lamps light it as they light every hit; indirect light is taken from the lightmap where the ray would
// have ended, for the mesh has none (none of rays that would have met nothing). The sky is hidden from receivers, not from itself: its
// rays go on. Before stand_in(). Returns how many rays there are.
std::size_t meet_dynamic(const DynamicWorld& world, const Bake& bake, const RunOptions& options, HitSurfaces& hits);

StageInfo info_shadow_rays();

}  // namespace plumb::probes
