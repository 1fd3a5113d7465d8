// Composition: what leaves a diffuse surface towards the viewer,
//
//     L = rho / pi (E_direct + E_indirect) + M / pi.
#pragma once

#include "core/number.h"

namespace plumb::compose {

// The twin's uniform block (std140).
struct ComposeUniforms {
    float environment[4];  // xyz: radiance where no surface is, W/(m2 sr)
    float inv_pi;
    std::int32_t width, height;
    std::int32_t padding;
};
static_assert(sizeof(ComposeUniforms) == 32);

// Images are [height][width] rgba32f.
struct ComposeInputsView {
    ComposeUniforms u;
    const float* normal;    // w: 1 on a surface, 0 where nothing is
    const float* albedo;    // rho
    const float* emission;  // radiant exitance M, W/m2
    const float* direct;    // irradiance, W/m2
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
    const vec3<F> direct = xyz<F>(N::fetch4(in.direct, pixel));      tap("direct", direct, "E_direct, W/m2");
    const vec3<F> indirect = xyz<F>(N::fetch4(in.indirect, pixel));  tap("indirect", indirect, "E_indirect, W/m2");

    const F inv_pi(in.u.inv_pi);
    vec3<F> radiance{(rho.x * (direct.x + indirect.x) + exitance.x) * inv_pi,
                     (rho.y * (direct.y + indirect.y) + exitance.y) * inv_pi,
                     (rho.z * (direct.z + indirect.z) + exitance.z) * inv_pi};
    const float* e = in.u.environment;
    radiance = select3<F>(covered, radiance, vec3<F>{F(e[0]), F(e[1]), F(e[2])});
    tap("radiance", radiance, "L = (rho (E_direct + E_indirect) + M) / pi, W/(m2 sr)");
    return radiance;
}

}  // namespace plumb::compose
