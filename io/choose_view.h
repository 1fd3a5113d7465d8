// A camera and a light for scenes that come without. Private to io/.
#pragma once

#include "core/scene.h"

namespace plumb::io {

// Both look at the middle of the scene's bounds, from far enough to see all of it. Each adds a note that says what was
// chosen and why.
void choose_camera(Scene& scene, const Geometry& geometry);
void choose_light(Scene& scene, const Geometry& geometry);

}  // namespace plumb::io
