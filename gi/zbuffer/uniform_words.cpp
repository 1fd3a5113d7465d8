#include "gi/uniform_words.h"

namespace plumb::zbuffer {

std::vector<StageWords> uniform_words() {
    return {
        {"",
         {{".lights", "", "how many"},
          {".diffuse", "", "1: N . L counts"},
          {".specular", "", "1: the lobe counts", "0"},
          {".blinn", "", "1: of the half vector; 0: of the mirrored one"},
          {".published", "", "1: as the listings have it", "0"},
          {".saturated", "", "1: colours end at 1", "0"},
          {".materials", "", "how many"},
          {".objects", "", "how many"},
          {".ambient", "W/m2", "xyz: irradiance that is there without a lamp", "0"},
          {".eye", "m", "xyz: world, of the viewer"},
          {"triangles", "", "that id counts"},
          {"vertices", "", "how many there are"},
          {"emits", "", "1: emission is shown"},
          {"row", "", "items of a row of the vertices' light"},
          {"eye", "m", "xyz: world, of the viewer"},
          {"count", "", "vertices"},
          {"normal", "", "0 the G-buffer's, 1 the vertices' interpolated and made unit, 2 the same as they come"}}},
    };
}

}  // namespace plumb::zbuffer
