// Pictures of each step of a bake, to look at (IPR figures 3.8 to 3.20, 5.14): on the lightmap, and in the scene.
#pragma once

#include <string>
#include <vector>

#include "core/view.h"
#include "gi/probes/bake.h"

namespace plumb::probes {

// Colours from 0 to 1, to be shown as they are.
struct DebugLayer {
    std::string name;     // "charts", "clusters.scene"
    std::string node;     // of the step that made it
    std::string meaning;
    Image4 picture;
};

struct DebugView {
    View view;
    glm::ivec2 size{0};
    int receiver = -1;  // whose alpha and rays are shown; -1: the one in the middle of the list
};

// What can be drawn of what is there: of a part of a bake no clusters.
std::vector<DebugLayer> debug_layers(const Bake& bake, const raster::Surfaces& surfaces, const DebugView& view,
                                     const RunOptions& options);

}  // namespace plumb::probes
