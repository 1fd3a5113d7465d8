#include "gi/uniform_words.h"

namespace plumb::rsm {

std::vector<StageWords> uniform_words() {
    return {
        {"",
         {{"least_distance2", "m2", "floor of |x - x_p|^2", "1e-37: no floor, but the inverse does not overflow", 1e-37},
          {"scale", "", "of the sum: 1 / pi = 0.31830987, since a texel of flux Phi sends Phi / pi; 1 where the flux is over pi already"},
          {"samples", "", "of a pixel; the pattern gives it"},
          {"rotations", "", "of the pattern: a power of two, a column of its table each", "1: one pattern for all pixels; a pattern of one's own gives it"},
          {"seed", "", "of the hash that chooses a pixel's rotation", "0 where rotations is 1", 0, "rotations"},
          {"reach", "texels", "the pattern's largest |dx| or |dy|, of continuous ones 2 more than its whole part; the pattern gives it"},
          {"axis", "", "xyz: unit, towards the light along its axis; a view_proj gives it"},
          {"directions", "", "paths of a pixel"},
          {"steps", "", "samples of a path"},
          {"tile", "pixels", "side of the tile that deals out rotations, whose square they are, in Bayer's order; 0: a hash of the pixel does", "0", 0},
          {"fade", "1/texels", "one over how far from a clamped map's border samples begin to hide less, to nothing at the border", "1e30: at once", 1e30},
          {"slots", "", "of the micro linear buffer, 2 to 32", "0: without visibility"},
          {"propagates", "", "-1: Algorithms 3 and 6; 0: Algorithm 2"},
          {"texel_area", "", "a texel at x_p covers h^3 / |n_p . (xyz - w x_p)| m2, h the map's row w of x_p; a view_proj gives it", "0 where sample_area is 0", 0},
          {"sample_area", "", "1 / pi = 0.31830987: a sample is a disc of its texels' area, sample_area times it being added to d^2", "0: a sample is a point, as (3.2) has it", 0},
          {"thickness", "m", "how far below a sample, away from the light, its surface is taken to reach: it hides the slots down to there", "0: a sample hides what is in its own slot, as VRSM 3.3 has it", 0}}},
    };
}

}  // namespace plumb::rsm
