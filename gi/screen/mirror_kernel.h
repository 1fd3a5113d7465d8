// What mirrors show (LRA 4.3.1, 6.3.1): the algorithm that mirror.comp mirrors line by line.
//
//     L_r = k f a L(q) + k_s / R sum over R rays of w f a L(q)
//     L(q): of the camera's hits the picture there; of the maps' (rho E_direct + M) / pi
//     L   = L_0 + L_r                   L_0: the picture without reflections
//
// k: the mirror's reflectance, k_s: that of Phong's lobe, w: the ray's weight (lobe_kernel.h); f: fades towards the picture's border; a = 1 / (1 + (t / d)^2), t the distance along the ray.
//
// differs: the listing adds a light's flux, once a light, takes what is black for what was missed, and multiplies by the
// receiver's own shadow. All lights light the hit here, it sends what it emits, and a mirror in the shadow is one.
#pragma once

#include "core/number.h"

namespace plumb::screen {

// The twin's uniform block (std140).
struct MirrorUniforms {
    float inv_pi;
    float fade;         // texels from the border within which hits of the camera fade; 0: none does
    float attenuation;  // 1 / d, 1/m; 0: a = 1
    std::int32_t width, height;
    float share;         // 1 / R; without lobes 0
    std::int32_t rays;   // R; 0: mirrors alone
    std::int32_t across; // pictures beside each other in what is of rays
    std::int32_t others; // 1: rays may have met what the camera does not see; 0: albedo, emission and direct are not read
    std::int32_t padding[3];
};
static_assert(sizeof(MirrorUniforms) == 48);

// Images are [height][width] rgba32f, but hit, albedo, emission, direct and drawn, which are sheets of 1 + R such pictures.
struct MirrorInputsView {
    MirrorUniforms u;
    const float* hit;         // as screen.reflect writes it
    const float* mirror;      // xyz reflectance
    const float* composed;    // L_0, W/(m2 sr)
    const float* albedo;      // of what was met in another view: rho
    const float* emission;    // M, W/m2
    const float* direct;      // E_direct, W/m2
    const float* lobe;        // xyz k_s; null: 0
    const float* drawn;       // as screen.lobe writes it: w weight; read where R > 0
    float* reflection;        // out: xyz L_r, W/(m2 sr); w 1: something was met
    float* radiance;          // out: xyz L, W/(m2 sr)
};

template <class F>
struct Mirrored {
    vec4<F> reflection, radiance;
    template <class Each>
    void components(Each each) const {
        for (const vec4<F>& v : {reflection, radiance}) each(v.x), each(v.y), each(v.z), each(v.w);
    }
};

// 1 within the picture, 0 at its border.
template <class F, class Tap>
PLUMB_INLINE F fade_of(const MirrorUniforms& u, const vec4<F>& hit, Tap& tap) {
    const F half(0.5f), x = hit.x + half, y = hit.y + half;
    const F nearest = min(min(x, F(float(u.width)) - x), min(y, F(float(u.height)) - y));
    const F fade = clamp(nearest / F(u.fade), F(0.0f), F(1.0f));
    tap("fade", fade, "f: texels to the border, over those within which hits fade");
    return fade;
}

// What one ray of a pixel shows, w 1 where it met something. item: of the sheet; k: what its light is multiplied by.
template <class F, class Tap>
PLUMB_INLINE vec4<F> shown_by(const MirrorInputsView& in, index_t<F> item, index_t<F> pixel, const vec3<F>& k, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const MirrorUniforms& u = in.u;
    const F zero(0.0f), one(1.0f), inv_pi(u.inv_pi);
    const vec4<F> hit = N::fetch4(in.hit, item);                  tap("distance", hit.z, "t, m");
    const I at_x = N::truncate_to_index(hit.x), at_y = N::truncate_to_index(hit.y), texel = at_y * I(u.width) + at_x;
    const mask_t<F> met = hit.w > zero;
    const mask_t<F> of_camera = (hit.w == one) & in_range(at_x, I(u.width)) & in_range(at_y, I(u.height));
    const vec3<F> shown = xyz<F>(N::fetch4(in.composed, select(of_camera, texel, pixel)));
    tap("shown", shown, "of the camera's hit: the picture there, W/(m2 sr)");
    const vec3<F> black{zero, zero, zero};
    const vec3<F> rho = u.others != 0 ? xyz<F>(N::fetch4(in.albedo, item)) : black;
    const vec3<F> m = u.others != 0 ? xyz<F>(N::fetch4(in.emission, item)) : black;
    const vec3<F> e = u.others != 0 ? xyz<F>(N::fetch4(in.direct, item)) : black;
    const vec3<F> lit{(rho.x * e.x + m.x) * inv_pi, (rho.y * e.y + m.y) * inv_pi, (rho.z * e.z + m.z) * inv_pi};
    tap("lit", lit, "of another view's hit: (rho E_direct + M) / pi, W/(m2 sr)");
    F factor = one;
    if (u.fade > 0.0f) factor = select(of_camera, fade_of(u, hit, tap), one);
    const F far = hit.z * F(u.attenuation);
    factor = factor * (one / (one + far * far));                  tap("factor", factor, "f a");
    tap("mirror", k, "k, or k_s w / R");
    const vec3<F> from = select3<F>(of_camera, shown, lit);
    const vec3<F> by = select3<F>(met, vec3<F>{k.x * (factor * from.x), k.y * (factor * from.y), k.z * (factor * from.z)}, black);
    return vec4<F>(by, select(met, one, zero));
}

template <class F, class Tap>
PLUMB_INLINE Mirrored<F> mirror(const MirrorInputsView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const MirrorUniforms& u = in.u;
    const F zero(0.0f);
    const I pixel = py * I(u.width) + px;
    vec3<F> k = xyz<F>(N::fetch4(in.mirror, pixel)), l_r{zero, zero, zero};
    const vec3<F> k_s = in.lobe ? xyz<F>(N::fetch4(in.lobe, pixel)) : l_r;
    F met = zero;
    for (int j = 0; j <= u.rays; ++j) {
        tap.sample(j);
        const I x = px + I(j % u.across * u.width), y = py + I(j / u.across * u.height), item = y * I(u.across * u.width) + x;
        if (j > 0) {
            const F w = N::fetch(in.drawn, item * I(4) + I(3)), share = w * F(u.share);
            tap("weight", w, "w");
            k = {k_s.x * share, k_s.y * share, k_s.z * share};
        }
        const vec4<F> by = shown_by<F>(in, item, pixel, k, tap);
        l_r = {l_r.x + by.x, l_r.y + by.y, l_r.z + by.z};
        met = max(met, by.w);
    }
    tap.sample(-1);
    tap("reflection", l_r, "L_r, W/(m2 sr)");
    const vec4<F> l_0 = N::fetch4(in.composed, pixel);
    const vec3<F> l{l_0.x + l_r.x, l_0.y + l_r.y, l_0.z + l_r.z}; tap("radiance", l, "L_0 + L_r, W/(m2 sr)");
    return {vec4<F>(l_r, met), vec4<F>(l, l_0.w)};
}

struct MirrorKernel {
    using View = MirrorInputsView;
    template <class F, class Tap>
    PLUMB_INLINE static Mirrored<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return mirror<F>(in, px, py, tap);
    }
    template <class F>
    static void store(const View& in, index_t<F> at, const Mirrored<F>& m, mask_t<F> active) {
        number<F>::store4(in.reflection, at, m.reflection, active);
        number<F>::store4(in.radiance, at, m.radiance, active);
    }
};

}  // namespace plumb::screen
