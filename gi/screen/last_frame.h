// What a frame leaves of its gathered light for the next (screen.reuse).
#pragma once

#include "core/image.h"
#include "core/view.h"

namespace plumb::screen {

// Empty before the first.
struct LastFrame {
    Image4 irradiance, age;   // as screen.reuse has made them
    Image4 position, normal;  // of the points that they are of
    View view;                // that sees them
    glm::ivec2 frame{0};      // pixels of the picture, of which they may be half
    bool empty() const { return irradiance.empty(); }
};

}  // namespace plumb::screen
