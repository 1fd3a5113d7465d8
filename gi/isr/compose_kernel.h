// Composition of direct and indirect light (ISR (29)): the algorithm that compose.comp mirrors line by line.
//
//     L = (rho (E_direct saturate(A + 1 - k_ssao) + k_isr E + A E_ambient) + M) / pi
//
// E irradiance from surfaces, A accessibility, E_ambient = pi times the environment's radiance.
//
// differs: as printed, and in variant `published`, L = rho E_direct / pi saturate(A + 1 - k_ssao) + k_isr E: there the
// gather holds a factor of the receiver (its mask), but neither its reflectance nor 1 / pi, and nothing is ambient. E is then
// made of colours without a unit, and is added times the radiance for which a colour of 1 stands.
//
// With k_isr = 0, k_ssao = 0 and no ambient light this is gi/compose without indirect light, to the bit.
#pragma once

#include "core/number.h"

namespace plumb::isr {

// The twin's uniform block (std140).
struct ComposeUniforms {
    float environment[4];  // xyz: radiance where no surface is, W/(m2 sr)
    float ambient[4];      // xyz: irradiance of a point that nothing hides, W/m2
    float inv_pi;
    float k_ssao, k_isr;   // 0..1
    std::int32_t published;
    std::int32_t width, height;
    float light_unit;      // W/(m2 sr) for which a colour of 1 stands; read where published
    std::int32_t occlusion;  // 1: (29) adds occlusion; read where published
};
static_assert(sizeof(ComposeUniforms) == 64);

// Images are [height][width] rgba32f.
struct ComposeInputsView {
    ComposeUniforms u;
    const float* normal;    // w: 1 on a surface, 0 where nothing is
    const float* albedo;    // rho
    const float* emission;  // radiant exitance M, W/m2
    const float* direct;    // irradiance, W/m2
    const float* indirect;  // xyz irradiance, W/m2, w accessibility
    float* radiance;        // out: W/(m2 sr)
};

template <class F, class Tap>
PLUMB_INLINE vec3<F> compose(const ComposeInputsView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    const ComposeUniforms& u = in.u;
    const index_t<F> pixel = py * index_t<F>(u.width) + px;
    const mask_t<F> covered = N::fetch4(in.normal, pixel).w > F(0.0f);
    const vec3<F> rho = xyz<F>(N::fetch4(in.albedo, pixel));         tap("albedo", rho, "rho");
    const vec3<F> exitance = xyz<F>(N::fetch4(in.emission, pixel));  tap("emission", exitance, "M, W/m2");
    const vec3<F> direct = xyz<F>(N::fetch4(in.direct, pixel));      tap("direct", direct, "E_direct, W/m2");
    const vec4<F> lit = N::fetch4(in.indirect, pixel);
    const vec3<F> indirect = xyz<F>(lit);                            tap("indirect", indirect, "E, W/m2; published: a colour");
    const F open = lit.w;                                            tap("accessibility", open, "A");

    const F term = u.published != 0 && u.occlusion != 0 ? F(1.0f) - open : open;
    const F passes = clamp(term + F(1.0f) - F(u.k_ssao), F(0.0f), F(1.0f));
    tap("passes", passes, "ISR (29): saturate(A + 1 - k_ssao)");
    const F k_isr(u.k_isr), inv_pi(u.inv_pi);
    const F e[3] = {k_isr * indirect.x, k_isr * indirect.y, k_isr * indirect.z};
    vec3<F> radiance;
    if (u.published != 0) {
        const F unit(u.light_unit);
        radiance = {(rho.x * (direct.x * passes) + exitance.x) * inv_pi + unit * e[0],
                    (rho.y * (direct.y * passes) + exitance.y) * inv_pi + unit * e[1],
                    (rho.z * (direct.z * passes) + exitance.z) * inv_pi + unit * e[2]};
    } else {
        const F ambient[3] = {open * F(u.ambient[0]), open * F(u.ambient[1]), open * F(u.ambient[2])};
        radiance = {(rho.x * (direct.x * passes + e[0] + ambient[0]) + exitance.x) * inv_pi,
                    (rho.y * (direct.y * passes + e[1] + ambient[1]) + exitance.y) * inv_pi,
                    (rho.z * (direct.z * passes + e[2] + ambient[2]) + exitance.z) * inv_pi};
    }
    radiance = select3<F>(covered, radiance, vec3<F>{F(u.environment[0]), F(u.environment[1]), F(u.environment[2])});
    tap("radiance", radiance, "ISR (29): L, W/(m2 sr)");
    return radiance;
}

struct ComposeKernel {
    using View = ComposeInputsView;
    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return vec4<F>(compose<F>(in, px, py, tap), F(0.0f));
    }
    static float* out(const View& in) { return in.radiance; }
};

}  // namespace plumb::isr
