// The radiance that a probe's relight rays bring: the algorithm that radiance.comp mirrors line by line (IPR 3.3.1.1, 3.3.1.5).
//
//     f = emitted + rho / pi direct + share I(uv)          share = rho / pi, a constant c, or rho itself
//
// emitted is the surface's own radiance, or the sky's; I the last lightmap where the ray ends. Where the ray met nothing, a back, or
// a surface without receiver, f is what is emitted alone.
//
// differs: rho / pi turns irradiance into the radiance of a diffuse surface. The thesis adds c I, c = 0.19 ("static reflection
// constant"), or "a material reflection" times I: both stay, for what they show (README.md).
#pragma once

#include "gi/probes/lightmap_kernel.h"

namespace plumb::probes {

// The twin's uniform block (std140).
struct RadianceUniforms {
    std::int32_t width, height;  // rays of a probe; probes
    std::int32_t side, levels;   // of the lightmap: T, and levels of detail
    std::int32_t feedback;       // 0: rho / pi; 1: `constant`; 2: rho
    float constant;              // 1/sr
    std::int32_t padding[2];
};
static_assert(sizeof(RadianceUniforms) == 32);

struct RadianceView {
    RadianceUniforms u;
    const float* surface;   // [height][width][4]: xyz reflectance rho; w 1: a front with a place on the lightmap, else 0
    const float* emitted;   // [height][width][4]: xyz radiance, W/(m2 sr)
    const float* direct;    // [height][width][4]: xyz irradiance by lights, W/m2
    const float* place;     // [height][width][4]: xy of the lightmap in 0..1, z the level that is looked up, whole
    const float* lightmap;  // [rows of the strip][side][4]: xyz irradiance, W/m2
    float* radiance;        // out: [height][width][4]: xyz f, W/(m2 sr); w 0
};

template <class F, class Tap>
PLUMB_INLINE vec4<F> radiance(const RadianceView& in, index_t<F> ray, index_t<F> probe, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const RadianceUniforms& u = in.u;
    const I at = probe * I(u.width) + ray;
    const vec4<F> surface = N::fetch4(in.surface, at);
    const vec3<F> rho = xyz<F>(surface);                          tap("rho", rho, "reflectance where the ray ends");
    const mask_t<F> reflects = surface.w > F(0.0f);               tap("reflects", reflects, "1: a front with a place on the lightmap");
    const vec3<F> emitted = xyz<F>(N::fetch4(in.emitted, at));    tap("emitted", emitted, "its own radiance, W/(m2 sr)");
    const vec3<F> direct = xyz<F>(N::fetch4(in.direct, at));      tap("direct", direct, "irradiance by lights, W/m2");
    const vec4<F> place = N::fetch4(in.place, at);
    // Whatever a dump holds, no level is left.
    const I level = max(I(0), min(N::truncate_to_index(place.z), I(u.levels - 1)));
    tap("level", level, "of the lightmap");
    const vec3<F> indirect = lightmap_at<F>({in.lightmap, u.side, u.levels}, {place.x, place.y}, level, tap);
    tap("indirect", indirect, "I(uv), W/m2");
    const F one_over_pi(0.318309886f), constant(u.constant);
    const vec3<F> diffuse{rho.x * one_over_pi, rho.y * one_over_pi, rho.z * one_over_pi};
    vec3<F> share = diffuse;
    if (u.feedback == 1) share = {constant, constant, constant};
    if (u.feedback == 2) share = rho;
    tap("share", share, "rho / pi; published: a constant, or rho; 1/sr");
    const vec3<F> f{emitted.x + (diffuse.x * direct.x + share.x * indirect.x),
                    emitted.y + (diffuse.y * direct.y + share.y * indirect.y),
                    emitted.z + (diffuse.z * direct.z + share.z * indirect.z)};
    const vec3<F> brought = select3<F>(reflects, f, emitted);
    tap("f", brought, "emitted + rho / pi direct + share I; emitted where nothing reflects; W/(m2 sr)");
    return vec4<F>(brought, F(0.0f));
}

struct RadianceKernel {
    using View = RadianceView;
    static constexpr int band = 4;
    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> ray, index_t<F> probe, Tap& tap) {
        return radiance<F>(in, ray, probe, tap);
    }
    static float* out(const View& in) { return in.radiance; }
};

}  // namespace plumb::probes
