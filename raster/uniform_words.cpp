#include "raster/uniform_words.h"

namespace plumb::raster {

std::vector<StageWords> uniform_words() {
    return {
        {"gbuffer.layer",
         {{"farther", "", "1; where z is reversed -1"}}},
        {"rsm",
         {{"light.position", "m", "world; not read of parallel rays"},
          {"light.cos_outer", "", "cosine of the cone's outer half angle; of a point light -2"},
          {"light.direction", "", "unit: the way the light travels"},
          {"light.falloff_scale", "", "1 / (cos_inner - cos_outer); a large number where they are equal"},
          {"light.intensity", "", "W/sr; of parallel rays, or of a radius, irradiance across the light, W/m2"},
          {"light.directional", "", "1: parallel rays; 0: spot or point"},
          {"light.inverse_radius2", "1/m2", "1 / radius^2 of a light that ends at it, ISR (16)", "0: it falls off as 1 / d^2"},
          {"light.radius2", "m2", "radius^2", "0"},
          {"texel_scale", "", "side of a texel at a depth of 1 m, m/m; of parallel rays m"},
          {"half_width", "", "half the map's side, in the same unit"}}},
        {"",
         {{"viewer", "m", "xyz: world, of the viewer, w 1; of parallel rays the direction towards it, w 0"},
          {"eye", "m", "world: where linear depth starts"},
          {"forward", "", "unit: the way the viewer looks"},
          {"pixel_area", "", "of a pixel at depth 1 m, m2/m2; of parallel rays m2", "0 where no texture has levels"}}},
    };
}

}  // namespace plumb::raster
