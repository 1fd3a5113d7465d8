#include "gi/uniform_words.h"

namespace plumb::ddgi {

std::vector<StageWords> uniform_words() {
    return {
        {"ddgi.blend",
         {{"width", "texels", "of the atlas"},
          {"height", "texels", "of the atlas"},
          {"side", "texels", "of a tile, without its gutter"},
          {"columns", "", "tiles of a row"},
          {"probes", "", "how many there are"},
          {"rays", "", "of each probe"},
          {"moments", "", "1: means of distance and its square; 0: irradiance"},
          {"sharpness", "", "power of the cosine that weighs a ray's distance; 1 for irradiance"},
          {"hysteresis", "", "share of the last round that a texel keeps", "0: none"},
          {"scale", "", "factor of what a ray brings"},
          {"farthest", "m", "where distances are cut"},
          {"least_weight", "", "a ray that weighs less does not count"}}},
        {"ddgi.border",
         {{"width", "texels", "of the atlas"},
          {"height", "texels", "of the atlas"},
          {"side", "texels", "of a tile, without its gutter"}}},
        {"ddgi.sample",
         {{"side", "texels", "of a tile of irradiance, without its gutter"},
          {"depth_side", "texels", "of a tile of moments, without its gutter"},
          {"count_x", "", "probes along x"},
          {"count_y", "", "along y"},
          {"count_z", "", "along z"},
          {"visibility", "", "1: probes are weighed by Chebyshev's bound on their moments", "0: all are seen"},
          {"wrapped", "", "1: weighed by the side of the surface that a probe lies on", "0"},
          {"root", "", "1: means are of square roots of the irradiance", "0"},
          {"viewer", "", "1: the viewer stands at eye; 0: the image view tells where"},
          {"scale", "", "of what texels hold, to W/m2"},
          {"normal_bias", "m", "by which the point moves along its normal", "0"},
          {"view_bias", "m", "and towards the viewer", "0"},
          {"crush", "", "weights below it become w^3 / crush^2"},
          {"least_weight", "", "floor of a probe's weight"},
          {"origin", "m", "xyz: world, of probe (0, 0, 0)"},
          {"spacing", "m", "xyz: between probes"},
          {"eye", "m", "xyz: world, of the viewer"}}},
    };
}

}  // namespace plumb::ddgi
