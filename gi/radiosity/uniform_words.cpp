#include "gi/uniform_words.h"

namespace plumb::radiosity {

std::vector<StageWords> uniform_words() {
    return {
        {"radiosity.gather",
         {{"count", "", "elements of the block"},
          {"elements", "", "of the scene"}}},
        {"radiosity.items",
         {{"vertices", "", "of the scene"},
          {"triangles", "", "of the scene"},
          {"texel", "", "2 / width: of a face's coordinates"},
          {"slack", "", "how far beyond its corners a triangle may reach by rounding, of the same", "0"}}},
        {"radiosity.lookup",
         {{"triangles", "", "that id counts"},
          {"elements", "", "of the scene"}}},
        {"radiosity.reduce",
         {{"across", "texels", "of a box"},
          {"down", "texels", "of a box"},
          {"rows", "texels", "of a hemicube, before"},
          {"weighted", "", "1: the first pass, which multiplies by the texels' form factors"},
          {"gain", "", "factor of the sums", "1"}}},
    };
}

}  // namespace plumb::radiosity
