// Composition: what leaves a diffuse surface towards the viewer,
//
//     L = rho / pi (E_direct + E_indirect) + M / pi + (1 - alpha) C_shadow,
//
// alpha the shadow density, C_shadow the shadow colour (VRSM 4.3); black by default, and then left out. With E_direct = pi
// alpha, as printed (gi/direct), that is mix(C_shadow, rho, alpha) and indirect light.
#pragma once

#include "core/number.h"

namespace plumb::compose {

// The twin's uniform block (std140).
struct ComposeUniforms {
    float environment[4];  // xyz: radiance where no surface is, W/(m2 sr)
    float inv_pi;
    std::int32_t width, height;
    std::int32_t shadowed;  // 0: the shadow colour is black, and nothing is added
    float shadow_color[4];  // xyz: radiance of a surface without direct light, W/(m2 sr)
};
static_assert(sizeof(ComposeUniforms) == 48);

// Images are [height][width] rgba32f.
struct ComposeInputsView {
    ComposeUniforms u;
    const float* normal;    // w: 1 on a surface, 0 where nothing is
    const float* albedo;    // rho
    const float* emission;  // radiant exitance M, W/m2
    const float* direct;    // irradiance, W/m2; w: shadow density
    const float* indirect;  // irradiance, W/m2
    float* radiance;        // out: W/(m2 sr)
};

template <class F, class Tap>
PLUMB_INLINE vec3<F> compose(const ComposeInputsView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    const index_t<F> pixel = py * index_t<F>(in.u.width) + px;
    const mask_t<F> covered = N::fetch4(in.normal, pixel).w > F(0.0f);
    const vec3<F> rho = xyz<F>(N::fetch4(in.albedo, pixel));         tap("albedo", rho, "rho");
    const vec3<F> exitance = xyz<F>(N::fetch4(in.emission, pixel));  tap("emission", exitance, "M, W/m2");
    const vec4<F> lit = N::fetch4(in.direct, pixel);
    const vec3<F> direct = xyz<F>(lit);                              tap("direct", direct, "E_direct, W/m2");
    const vec3<F> indirect = xyz<F>(N::fetch4(in.indirect, pixel));  tap("indirect", indirect, "E_indirect, W/m2");

    const F inv_pi(in.u.inv_pi);
    vec3<F> radiance{(rho.x * (direct.x + indirect.x) + exitance.x) * inv_pi,
                     (rho.y * (direct.y + indirect.y) + exitance.y) * inv_pi,
                     (rho.z * (direct.z + indirect.z) + exitance.z) * inv_pi};
    if (in.u.shadowed != 0) {
        const float* c = in.u.shadow_color;
        const F shadow = F(1.0f) - lit.w;                            tap("shadow", shadow, "1 - density");
        radiance = {radiance.x + shadow * F(c[0]), radiance.y + shadow * F(c[1]), radiance.z + shadow * F(c[2])};
    }
    const float* e = in.u.environment;
    radiance = select3<F>(covered, radiance, vec3<F>{F(e[0]), F(e[1]), F(e[2])});
    tap("radiance", radiance, "L = (rho (E_direct + E_indirect) + M) / pi + shadow C, W/(m2 sr)");
    return radiance;
}

struct ComposeKernel {
    using View = ComposeInputsView;
    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return vec4<F>(compose::compose<F>(in, px, py, tap), F(0.0f));
    }
    static float* out(const View& in) { return in.radiance; }
};

}  // namespace plumb::compose
