// What the run time's first two stages read of a bake, from its data textures alone (textures.h): rays, harmonics and their weights
// for probes.lambda; reflectance, emission and places on the lightmap for probes.radiance.
#pragma once

#include "core/image.h"
#include "core/scene.h"
#include "gi/probes/stand_in.h"
#include "gi/probes/textures.h"

namespace plumb::probes {

// As LambdaInputs has them.
struct RayTables {
    int probes = 0, rays = 0, coefficients = 0;
    Buffer<float> harmonics;  // [rays][coefficients]
    Buffer<float> weights;    // [levels][rays], sr
};
// Weights follow from directions, which no texture holds: they are relight_directions(), whose harmonics the texture has to have to
// the bit. Throws InputError where it has others, and for a level's number of rays that is not 1 to all.
//
// differs: IPR (10) weighs all rays alike and needs no directions.
RayTables ray_tables(const BakeArrays& arrays, const std::vector<int>& level_rays);

// As RadianceInputs has them: [probes][rays]. Where no front was met: of the ray that stands for it, if any does (stand_in.h).
struct RaySurfaces {
    Buffer<glm::vec4> surface;  // xyz reflectance of the material; w 1 where a front was met, else all 0
    Buffer<glm::vec4> emitted;  // radiance, of the material or of the sky, W/(m2 sr); 0 of backs
    Buffer<glm::vec4> place;    // xy on the lightmap, z level 0; 0 where no front was met
};
// A material has one colour here: a texture's would need the triangle, which is in no data texture. Throws InputError for a material
// that there is not, or one with a texture of colour or emission that a ray meets.
//
RaySurfaces ray_surfaces(const BakeArrays& arrays, const Scene& scene, Escape escape, Unasked unasked = Unasked::nearest);

}  // namespace plumb::probes
