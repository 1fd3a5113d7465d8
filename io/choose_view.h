// A camera and a light for scenes that come without. Private to io/.
#pragma once

#include "core/scene.h"

namespace plumb::io {

// Each adds a note that says what was chosen and why. The camera looks at the middle of the scene's bounds, from far
// enough to see all of it.
void choose_camera(Scene& scene, const Geometry& geometry);

// By the scene's camera, which is chosen first: what that sees is lit. A directional light from over its left shoulder; a
// point light at the camera where that stands within the scene's bounds, as in a closed room, which has shadow inside.
void choose_light(Scene& scene, const Geometry& geometry);

}  // namespace plumb::io
