// Conventions of the graphics interfaces, as data. Kernels compute in the first; the others change matrices and
// addressing, so that one scene gives one picture through the matrices of any of them.
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
#include "core/image.h"

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

// From the clip space of a program that follows `convention`, half-pixel shift included, to the canonical one. Exact but
// for depth -1..1, which costs half a unit in the last place of w.
inline glm::dmat4 to_canonical(glm::ivec2 size, Convention convention) {
    const ConventionRules& r = rules(convention);
    const glm::dmat4 shift = half_pixel_shift(size, convention);
    glm::dmat4 m(1);
    m[3][0] = -shift[3][0];
    if (r.clip_y_up) m[1][1] = -1, m[3][1] = shift[3][1];
    if (r.depth_from_minus_1) m[2][2] = m[3][2] = 0.5;
    return m;
}

// What a device of that convention holds where this project holds a canonical value, for dumps to and from it.

// Depth after the division by w: what a shader multiplies by an inverse projection. The depth buffer itself holds 0..1
// in all of them, since glDepthRange maps OpenGL's -1..1 there.
inline double clip_depth_from_depth_buffer(double depth, Convention convention) {
    return rules(convention).depth_from_minus_1 ? 2 * depth - 1 : depth;
}
inline double depth_buffer_from_clip_depth(double depth, Convention convention) {
    return rules(convention).depth_from_minus_1 ? 0.5 * depth + 0.5 : depth;
}

// The row of memory in which row `y` from the top lies; its own inverse.
inline int memory_row(int y, int height, Convention convention) {
    return rules(convention).rows_from_bottom ? height - 1 - y : y;
}
// The image with its rows in the order of the convention's memory; its own inverse.
template <class T>
Image<T> in_memory_order(const Image<T>& image, Convention convention) {
    Image<T> out = image;
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) out(x, memory_row(y, image.height, convention)) = image(x, y);
    return out;
}

}  // namespace plumb
