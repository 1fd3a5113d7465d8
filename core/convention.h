// Conventions of the graphics interfaces, as data. Everything here computes in the first; the others change matrices
// and addressing when a program of theirs is read or checked, never a kernel.
//
//     view space                       clip space after the division by w    rows of the framebuffer
//
//     right-handed   left-handed       y down            y up                from the top    from the bottom
//       y              y   z           (-1,-1)           (-1,1)
//       |              |  /              +-------+         +-------+           0 +----+        2 +----+
//       +--- x         | /               |       |         |       |           1 |    |        1 |    |
//      /               +--- x            |       |         |       |           2 +----+        0 +----+
//     z                                  +-------+         +-------+
//     looks along -z   along +z                (1,1)             (1,-1)
//
//     name         view space     clip y   depth    rows from     pixel centres at
//     vulkan       right-handed   down     0..1     top left      i + 1/2
//     opengl       right-handed   up       -1..1    bottom left   i + 1/2
//     d3d11        left-handed    up       0..1     top left      i + 1/2
//     d3d9         left-handed    up       0..1     top left      i              (HEM 5.1, ISR 3.1)
//     left_handed  left-handed    down     0..1     top left      i + 1/2
//
// The world is right-handed with +Y up in all of them: a left-handed view space mirrors z.
#pragma once

#include <cmath>
#include <glm/glm.hpp>
#include <string>

#include "core/error.h"

namespace plumb {

enum class Convention : int { vulkan, opengl, d3d11, d3d9, left_handed };

struct ConventionRules {
    const char* name;
    bool view_left_handed;  // the viewer looks along +z, not along -z
    bool clip_y_up;
    bool depth_from_minus_1;  // depth -1..1, not 0..1
    bool rows_from_bottom;
    double pixel_centre;  // window coordinate of the centre of pixel 0
};

inline const ConventionRules& rules(Convention convention) {
    static constexpr ConventionRules table[] = {
        {"vulkan", false, false, false, false, 0.5},  //
        {"opengl", false, true, true, true, 0.5},     //
        {"d3d11", true, true, false, false, 0.5},     //
        {"d3d9", true, true, false, false, 0.0},      //
        {"left_handed", true, false, false, false, 0.5},
    };
    return table[int(convention)];
}

// Throws InputError at `place` ("scene.toml: line 3") for a name that is none of the five.
inline Convention parse_convention(const std::string& name, const std::string& place) {
    std::string known;
    for (int i = 0; i <= int(Convention::left_handed); ++i) {
        const char* candidate = rules(Convention(i)).name;
        if (name == candidate) return Convention(i);
        known += (i ? ", " : "") + std::string(candidate);
    }
    throw InputError(place + ": convention \"" + name + "\" is unknown; expected one of " + known);
}

// Window coordinates by the interface's own viewport transform, for a viewport that fills a frame of `size` pixels.
inline glm::dvec2 window_from_clip(const glm::dvec4& clip, glm::ivec2 size, Convention convention) {
    const ConventionRules& r = rules(convention);
    const double up = r.clip_y_up == r.rows_from_bottom ? clip.y : -clip.y;
    return {(clip.x / clip.w + 1) * 0.5 * size.x, (up / clip.w + 1) * 0.5 * size.y};
}

// The pixel that a window position falls into, row 0 on top.
inline glm::ivec2 pixel_from_window(const glm::dvec2& window, glm::ivec2 size, Convention convention) {
    const ConventionRules& r = rules(convention);
    const double shift = 0.5 - r.pixel_centre;
    const int row = int(std::floor(window.y + shift));
    return {int(std::floor(window.x + shift)), r.rows_from_bottom ? size.y - 1 - row : row};
}

// What a program multiplies its projection by, so that the picture does not shift: half a pixel towards the top left
// for Direct3D 9, whose viewport transform ignores that its pixel centres lie at whole coordinates; else the identity.
inline glm::dmat4 half_pixel_shift(glm::ivec2 size, Convention convention) {
    const double pixels = rules(convention).pixel_centre - 0.5;
    glm::dmat4 shift(1);
    shift[3][0] = 2 * pixels / size.x;
    shift[3][1] = -2 * pixels / size.y;
    return shift;
}

}  // namespace plumb
