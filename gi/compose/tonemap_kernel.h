// Tone mapping: radiance to the values of a display, encoded by the curve of sRGB (IEC 61966-2-1).
//
// All four operators are computed by formulas that have a twin; one is taken. x is exposure * radiance, by channel.
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
};
static_assert(sizeof(TonemapUniforms) == 16);

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

template <class F, class Tap>
PLUMB_INLINE vec3<F> tonemap(const TonemapInputsView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    const index_t<F> pixel = py * index_t<F>(in.u.width) + px;
    const vec3<F> radiance = xyz<F>(N::fetch4(in.radiance, pixel));  tap("radiance", radiance, "L, W/(m2 sr)");
    const F exposure(in.u.exposure);
    const int op = in.u.op;
    const vec3<F> mapped{tone_curve(op, exposure * radiance.x), tone_curve(op, exposure * radiance.y),
                         tone_curve(op, exposure * radiance.z)};     tap("mapped", mapped, "tone curve of exposure L");
    const vec3<F> display{srgb_encode(mapped.x), srgb_encode(mapped.y), srgb_encode(mapped.z)};
    tap("display", display, "IEC 61966-2-1, 0..1");
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
