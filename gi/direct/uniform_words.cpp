#include "gi/uniform_words.h"

#include "gi/direct/log_blur.h"
#include "gi/direct/visibility_filter.h"

namespace plumb::direct {

std::vector<StageWords> uniform_words() {
    return {
        {"direct",
         {{"lights", "", "how many: layers of visibility"},
          {"density", "", "1: w of the output is the shadow density; 2: density, and E / pi", "0: w is 0"}}},
        {log_blur_stage,
         {{"radius", "texels", "of the blur"},
          {"vertical", "", "0 along rows, 1 along columns"},
          {"c", "1/m", "of ISR (30): exponent for each metre behind the map"}}},
        {visibility_filter_stage,
         {{"radius", "pixels", "of the kernel"},
          {"vertical", "", "0 along rows, 1 along columns"},
          {"kind", "", "0: the Gaussian alone; 1: times how alike pixels are"},
          {"sigma_depth", "", "of kind = 1: of the depth, a share of it: beyond it from the pixel's plane weights vanish"},
          {"normal_slope", "", "of kind = 1: 1 / sigma of the normals' cosine"},
          {"normal_offset", "", "of kind = 1: 1 - normal_slope"}}},
        {"shadow",
         {{"eye", "m", "xyz: world, where the light's linear depth starts; a view_proj gives it"},
          {"forward", "", "xyz: unit, the way the light looks; a view_proj gives it"},
          {"footprint_scale", "", "side of a texel at a depth of 1 m, m/m; of parallel rays 0; a view_proj gives it"},
          {"footprint_base", "m", "side of a texel of parallel rays; else 0; a view_proj gives it"},
          {"bias", "m", "of test > 0: how far from a plane lies on it; else constant part of the depth bias; a bias of window depth is another formula"},
          {"slope_bias", "texels", "part that follows the slope, times the reach of the kernel", "0: a constant bias alone"},
          {"max_slope", "", "limit of that slope", "16"},
          {"perspective", "", "1 spot or point, 0 parallel rays; a view_proj gives it"},
          {"kernel", "texels", "side of the kernel of texels that are compared; of soft = 1 side of the square, 2: 1", "1: one texel"},
          {"samples", "", "kernel squared"},
          {"published", "", "1: VRSM Algorithm 4, or ISR Listing 8, as printed", "0"},
          {"face", "", "of a point light: the face whose points this map serves, 0 to 5", "-1: it serves all"},
          {"soft", "", "0 each texel lit or not, 1 comparisons weighed by what a square covers, 2 exponential shadow map"},
          {"c", "1/m", "of soft = 2: exponent for each metre behind the map", "0"},
          {"test", "", "what shadows: 0 depths, 1 what lies over the point's plane, 2 and has the point under its own", "0", 0.0},
          {"least_sine", "", "of test > 0: sine of the angle over the plane up to which nothing within the texels read shadows", "0", 0.0},
          {"rounding", "", "of test > 0: of stored positions, relative to their coordinates", "0", 0.0},
          {"beside", "", "of test > 0: 1: what shadows lies over the plane of x and two pixels beside it, too", "0", 0.0}}},
    };
}

}  // namespace plumb::direct
