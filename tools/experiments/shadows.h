// plumb experiment shadows: each light's visibility at each pixel, by every way of the shadow test, held against a ray to the light.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/image.h"
#include "gi/frame/frame.h"
#include "tools/shared/options.h"

namespace plumb::cli {

// A way of testing: what is set for it, and how far from the projection a texel that it reads lies at most, texels along a side.
struct ShadowWay {
    std::string name;
    std::vector<std::string> sets;
    double reach;
};
std::vector<ShadowWay> shadow_ways();

// Of all lights that shine, over pixels whose surface faces the light and lies within its cone.
struct ShadowErrors {
    std::size_t lit = 0, dark = 0;    // pixels, by rays
    std::size_t acne = 0, leak = 0;   // lit, and less than 1 - 1/16 visible; dark, and more than 1/16: beside no edge of a shadow
    std::size_t edge = 0;             // the same within the reach of an edge, where a map cannot know
    double light = 0;                 // irradiance that is missing or too much, over that of the lit: of all pixels
    double beside = 0;                // the same of acne and leak alone
};

struct ShadowRow {
    std::string scene, way;
    int size = 0;        // pixels a side
    int map = 0;         // texels a side, of the first light
    ShadowErrors errors;
    double ms = 0;       // of the shadow test
    Image4 where;        // red acne, blue leak, green edge; grey what is right
};

using ShadowTell = std::function<void(const std::string&)>;
// A row for each way, of a frame of size x size pixels. map: texels a side of every map; 0: the scene's own. set: preset and
// settings, under those of the way.
std::vector<ShadowRow> measure_shadows(const Scene& scene, const SceneOptions& set, const std::vector<ShadowWay>& ways,
                                       int size, int map, const RunOptions& options, const ShadowTell& tell);

}  // namespace plumb::cli
