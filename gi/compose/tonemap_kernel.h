// Tone mapping: radiance to the values of a display, channel by channel,
//
//     display = encode(curve(contrast(dimmer exposure L))).
//
// One of four curves is taken; the encoding is that of sRGB (IEC 61966-2-1), or a power.
#pragma once

#include "core/detmath.h"
#include "core/number.h"

namespace plumb::compose {

enum class Operator : int { clamp, exposure, reinhard, filmic };

// The twin's uniform block (std140).
struct TonemapUniforms {
    std::int32_t op;  // Operator
    float exposure;
    std::int32_t width, height;
    float dimmer;
    float contrast;   // 1: left out
    float inv_gamma;  // 0: the curve of sRGB
    std::int32_t padding;
};
static_assert(sizeof(TonemapUniforms) == 32);

struct TonemapInputsView {
    TonemapUniforms u;
    const float* radiance;  // [height][width] rgba32f, W/(m2 sr)
    float* display;         // out, rgba32f: sRGB-encoded, 0..1
};

// Hable 2010, "Uncharted 2: HDR lighting", slide 142: (x (A x + C B) + D E) / (x (A x + B) + D F) - E / F, with
// A, B, C, D, E, F = 0.15, 0.5, 0.1, 0.2, 0.02, 0.3.
//
// differs: the difference of the two quotients is taken on paper, so that nothing cancels where x is small:
// x (A (1 - E/F) x + B (C - E/F)) / (x (A x + B) + D F).
template <class F>
PLUMB_INLINE F filmic_curve(F x) {
    return x * (F(0.14f) * x + F(0.0166666675f)) / (x * (F(0.15f) * x + F(0.5f)) + F(0.06f));
}

// A power about middle grey, 0.18: in logarithms a line of slope `contrast` through it.
//
// differs: IPR figure A.1 has a contrast and prints no formula. Below 2^-100 it is black: a gamma would lift what is left of
// a number there, and that may be none of its digits.
template <class F>
PLUMB_INLINE F contrasted(F x, float contrast) {
    if (contrast == 1.0f) return x;
    x = min(max(x, F(0.0f)), F(1e10f));
    const F y = F(0.18f) * detmath::pow(x * F(5.55555534f), F(contrast));
    return max(y - F(0x1p-100f), F(0.0f));
}

template <class F>
PLUMB_INLINE F tone_curve(int op, F x) {
    const F one(1.0f);
    // Beyond 1e10 every curve has reached its end, and products stay finite.
    x = min(max(x, F(0.0f)), F(1e10f));
    if (op == int(Operator::exposure)) return -detmath::expm1(-x);     // IPR 3.3: 1 - exp(-x)
    if (op == int(Operator::reinhard)) return x / (one + x);              // Reinhard 2002 (3)
    if (op == int(Operator::filmic)) return filmic_curve(x + x) / filmic_curve(F(11.2f));  // white at 11.2, bias 2
    return min(x, one);
}

// 12.92 c below 0.0031308, 1.055 c^(1/2.4) - 0.055 above.
template <class F>
PLUMB_INLINE F srgb_encode(F c) {
    c = min(max(c, F(0.0f)), F(1.0f));
    const F curve = F(1.055f) * detmath::pow(c, F(0.416666657f)) - F(0.055f);
    return select(c <= F(0.0031308f), F(12.92f) * c, min(curve, F(1.0f)));
}

template <class F>
PLUMB_INLINE F encode(F c, float inv_gamma) {
    if (inv_gamma == 0.0f) return srgb_encode(c);
    return min(detmath::pow(min(max(c, F(0.0f)), F(1.0f)), F(inv_gamma)), F(1.0f));
}

template <class F, class Tap>
PLUMB_INLINE vec3<F> tonemap(const TonemapInputsView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    const index_t<F> pixel = py * index_t<F>(in.u.width) + px;
    const vec3<F> radiance = xyz<F>(N::fetch4(in.radiance, pixel));  tap("radiance", radiance, "L, W/(m2 sr)");
    const F exposure(in.u.exposure), dimmer(in.u.dimmer);
    const float contrast = in.u.contrast, inv_gamma = in.u.inv_gamma;
    const int op = in.u.op;
    const vec3<F> light{contrasted(dimmer * (exposure * radiance.x), contrast),
                        contrasted(dimmer * (exposure * radiance.y), contrast),
                        contrasted(dimmer * (exposure * radiance.z), contrast)};
    tap("light", light, "dimmer exposure L, with contrast");
    const vec3<F> mapped{tone_curve(op, light.x), tone_curve(op, light.y), tone_curve(op, light.z)};
    tap("mapped", mapped, "tone curve of light");
    const vec3<F> display{encode(mapped.x, inv_gamma), encode(mapped.y, inv_gamma), encode(mapped.z, inv_gamma)};
    tap("display", display, "encoded, 0..1");
    return display;
}

struct TonemapKernel {
    using View = TonemapInputsView;
    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return vec4<F>(tonemap<F>(in, px, py, tap), F(1.0f));
    }
    static float* out(const View& in) { return in.display; }
};

}  // namespace plumb::compose
