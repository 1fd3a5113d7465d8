#include "gi/uniform_words.h"

namespace plumb::filter {

std::vector<StageWords> uniform_words() {
    return {
        {"",
         {{"similarity", "", "0: distance from the point's plane; 1: difference of depth"},
          {"sigma_depth", "", "of the depth, a share of it: beyond it weights vanish"},
          {"normal_slope", "", "1 / sigma of the normals' cosine"},
          {"normal_offset", "", "1 - normal_slope"},
          {"full_width", "pixels", "of the full image"},
          {"full_height", "pixels", "of the full image"},
          {"coarse_width", "pixels", "of the coarse image"},
          {"coarse_height", "pixels", "of the coarse image"}}},
        {"filter.blur",
         {{"radius_x", "pixels", "of the kernel along x; 0 in a vertical pass"},
          {"radius_y", "pixels", "and along y"}}},
        {"filter.upsample",
         {{"mode", "", "0 bilateral, 1 bilinear, 2 as printed"}}},
    };
}

}  // namespace plumb::filter
