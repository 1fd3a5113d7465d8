// What relight rays meet, as the run time's light reads it: a G-buffer with a ray in each pixel, so that the stages which light
// pixels light hits as well, and what each hit sends by itself. It depends on the bake, materials and the sky; not on lamps.
#pragma once

#include "core/image.h"
#include "core/isa.h"
#include "core/scene.h"
#include "gi/probes/bake.h"
#include "gi/probes/stand_in.h"

namespace plumb::probes {

// Columns: rays; rows: probes. Where no front was met: of the ray that stands for it, if any does.
struct HitSurfaces {
    Image4 position;  // xyz m; 0 where no front was met
    Image4 normal;    // xyz unit, shading, towards the probe; w 1; all 0 where no front was met
    Image4 surface;   // xyz diffuse reflectance; w 1 where a front was met
    Image4 emitted;   // radiance that the surface emits, or the sky's, W/(m2 sr); 0 of backs
    Image4 place;     // xy on the lightmap, 0..1; z the level to look it up in: 0
};

// Materials, textures and the sky are the scene's, triangles the bake's. normal_maps: whether hits have them.
HitSurfaces hit_surfaces(const Scene& scene, const Bake& bake, const RunOptions& options, Unasked unasked = Unasked::nearest,
                         bool normal_maps = true);

// Each ray becomes what the one that tells in its place has found: ray_of is stand_ins(). hit_surfaces() ends with it.
void stand_in(const std::vector<std::int32_t>& ray_of, HitSurfaces& made);

}  // namespace plumb::probes
