// A view: the matrices through which a camera or a light sees, in double precision.
#pragma once

#include <glm/glm.hpp>
#include <limits>

namespace plumb {

// Canonical clip space is Vulkan's: x right, y DOWN, depth 0..1 after the division by w, pixel centres at + 0.5, the
// origin of the framebuffer at its top left. View space is right-handed: the viewer looks along -z. The two matrices may
// be those of another convention, as a program of that interface uploads them; `to_canonical` then leads back.
struct View {
    glm::dmat4 world_to_view{1};
    glm::dmat4 view_to_clip{1};
    glm::dmat4 to_canonical{1};    // from the clip space of view_to_clip: core/convention.h
    glm::dvec3 eye{0};             // position of the viewer; a directional light's is a point on its near plane
    glm::dvec3 forward{0, 0, -1};  // unit: where the viewer looks; linear depth of x is dot(x - eye, forward), metres
    bool orthographic = false;
    bool reversed_z = false;       // depth 1 at the near plane, 0 at the far plane
    double far = std::numeric_limits<double>::infinity();  // m, linear depth of the far plane

    // The left product comes first: a half-pixel shift then cancels exactly.
    glm::dmat4 world_to_clip() const { return to_canonical * view_to_clip * world_to_view; }
};

}  // namespace plumb
