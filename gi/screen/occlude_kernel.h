// Ambient occlusion over light from everywhere: the algorithm that occlude.comp mirrors line by line.
//
//     E' = o (E_indirect + E_ambient)
//
// Lamps have shadows: their direct light is not darkened again.
#pragma once

#include "core/number.h"

namespace plumb::screen {

// The twin's uniform block (std140).
struct OccludeUniforms {
    float ambient[4];  // xyz: irradiance from everywhere, W/m2
    std::int32_t width, height;
    std::int32_t padding[2];
};
static_assert(sizeof(OccludeUniforms) == 32);

struct OccludeInputsView {
    OccludeUniforms u;
    const float* indirect;  // [height][width] rgba32f: xyz W/m2; w goes through
    const float* open;      // [height][width] rgba32f: x open share; w 1 on a surface
    float* occluded;        // out: [height][width] rgba32f
};

template <class F, class Tap>
PLUMB_INLINE vec4<F> occlude(const OccludeInputsView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    const OccludeUniforms& u = in.u;
    const index_t<F> pixel = py * index_t<F>(u.width) + px;
    const vec4<F> e = N::fetch4(in.indirect, pixel);              tap("indirect", xyz<F>(e), "E_indirect, W/m2");
    const vec4<F> open = N::fetch4(in.open, pixel);               tap("open", open.x, "o");
    const vec3<F> lit{open.x * (e.x + F(u.ambient[0])), open.x * (e.y + F(u.ambient[1])), open.x * (e.z + F(u.ambient[2]))};
    const F zero(0.0f);
    const vec3<F> result = select3<F>(open.w > zero, lit, vec3<F>{zero, zero, zero});
    tap("occluded", result, "o (E_indirect + E_ambient), W/m2");
    return vec4<F>(result, e.w);
}

struct OccludeKernel {
    using View = OccludeInputsView;
    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return occlude<F>(in, px, py, tap);
    }
    static float* out(const View& in) { return in.occluded; }
};

}  // namespace plumb::screen
