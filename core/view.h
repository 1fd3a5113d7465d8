// A view: the matrices through which a camera or a light sees, in double precision.
#pragma once

#include <glm/glm.hpp>

namespace plumb {

// Canonical clip space is Vulkan's: x right, y DOWN, depth 0..1 after the division by w, pixel centres at + 0.5, the
// origin of the framebuffer at its top left. View space is right-handed: the viewer looks along -z.
struct View {
    glm::dmat4 world_to_view{1};
    glm::dmat4 view_to_clip{1};
    glm::dvec3 eye{0};             // position of the viewer; a directional light's is a point on its near plane
    glm::dvec3 forward{0, 0, -1};  // unit: where the viewer looks; linear depth of x is dot(x - eye, forward), metres
    bool orthographic = false;
    bool reversed_z = false;       // depth 1 at the near plane, 0 at the far plane

    glm::dmat4 world_to_clip() const { return view_to_clip * world_to_view; }
};

}  // namespace plumb
