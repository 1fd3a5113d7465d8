// A scene whose quads have, one by one, everything that surface.glsl and texture.glsl know.
#pragma once

#include "core/scene.h"

namespace plumb::mutants {

Scene quads();

}  // namespace plumb::mutants
