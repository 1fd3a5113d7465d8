// What the next bounce gathers (ISR chapter 6), B = B0 + rho E: the algorithm that bounce.comp mirrors line by line.
// Around the receivers nothing was gathered: B0 stays.
//
// What ISR (25) gathers, as printed, has the receiver's reflectance already: B = B0 + E, which is (8) all the same.
#pragma once

#include "core/number.h"

namespace plumb::isr {

// The twin's uniform block (std140).
struct BounceUniforms {
    std::int32_t width, height;  // of the sources, coarse pixels
    std::int32_t receivers_width, receivers_height;
    std::int32_t margin;         // coarse pixels of the sources left of and above the receivers
    std::int32_t reflected;      // 1: E has rho already
    std::int32_t padding[2];
};
static_assert(sizeof(BounceUniforms) == 32);

struct BounceInputsView {
    BounceUniforms u;
    const float* radiosity;    // [height][width] rgba32f: xyz B0, W/m2, w radiation mask
    const float* reflectance;  // [receivers_height][receivers_width] rgba32f: xyz rho
    const float* gathered;     // xyz E, W/m2
    float* bounced;            // out: [height][width] rgba32f
};

template <class F, class Tap>
PLUMB_INLINE vec4<F> bounce(const BounceInputsView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const BounceUniforms& u = in.u;
    const vec4<F> b0 = N::fetch4(in.radiosity, py * I(u.width) + px);
    tap("b0", xyz<F>(b0), "B0, W/m2");
    const I x = px - I(u.margin), y = py - I(u.margin);
    const mask_t<F> inside = in_range(x, I(u.receivers_width)) & in_range(y, I(u.receivers_height));
    tap("inside", inside, "1 if light was gathered there");
    const I i = select(inside, y * I(u.receivers_width) + x, I(0));
    const vec3<F> fetched = xyz<F>(N::fetch4(in.reflectance, i));
    const vec3<F> rho = u.reflected != 0 ? vec3<F>{F(1.0f), F(1.0f), F(1.0f)} : fetched;
    tap("rho", rho, "reflectance; 1 where E has it already");
    const vec3<F> e = xyz<F>(N::fetch4(in.gathered, i));          tap("irradiance", e, "E, W/m2");
    const vec3<F> sent{b0.x + rho.x * e.x, b0.y + rho.y * e.y, b0.z + rho.z * e.z};
    const vec3<F> b = select3<F>(inside, sent, xyz<F>(b0));       tap("radiosity", b, "B = B0 + rho E, W/m2");
    return vec4<F>(b, b0.w);
}

struct BounceKernel {
    using View = BounceInputsView;
    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return bounce<F>(in, px, py, tap);
    }
    static float* out(const View& in) { return in.bounced; }
};

}  // namespace plumb::isr
