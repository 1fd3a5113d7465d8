// Nodes of reflections that have a file of their own. Private to gi/frame.
#pragma once

#include "gi/frame/frame_graph.h"

namespace plumb::frame {

// What the maps of a light do not hold of their texels: normals where no gather reads them, reflectance, emission, triangles.
void add_seen(Context& c, int light, Nodes& nodes);

}  // namespace plumb::frame
