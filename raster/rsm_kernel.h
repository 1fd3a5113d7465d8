// One texel of a reflective shadow map (VRSM 4.2, LRA 4.2.2): the algorithm that rsm.frag mirrors.
//
// The flux of a texel is the reflected part of the power that the light sends through it:
//
//     spot          Phi = rho I(w) dw,     dw = (2 tan(a/2) / R)^2 cos^3
//     point         the same for each of its six faces, a = 90 degrees: dw = (2 / R)^2 cos^3
//     directional   Phi = rho E_perp A,    A = (side / R)^2
//
// A light that ends at its radius (ISR (16)) has the intensity of the distance at which it meets the surface.
//
// with a the full angle of the map, R its side in texels and cos the cosine between w and the light's axis. The texel's
// centre decides w, not the point that was hit: the sum over the map then depends on no geometry.
// differs: LRA's flux has neither the light's colour nor the cosine.
#pragma once

#include "raster/gbuffer_kernel.h"
#include "raster/light_kernel.h"

namespace plumb::raster {

// How the texels of a reflective shadow map are stored; `depth` is position's w.
struct RsmStore {
    Format position = Format::rgba32f, normal = Format::rgba32f, flux = Format::rgba32f, depth = Format::r32f;
};

struct RsmArgs {
    SurfaceArgs surfaces;
    float eye[3], forward[3];     // m; unit
    LightArgs light;
    float texel_scale;            // side of a texel: spot: at depth 1 m, m/m; directional: m
    float half_width;             // half the map's side, in the same unit
    std::int32_t size;            // texels a side
    float* position;              // [size][size] rgba32f, out
    float* normal;                // null where the map's depth alone is wanted
    float* flux;                  // null, but for gathers; not without normal
};

// Power that the light sends through texel (px, py) to `position`, W.
template <class F, class Tap>
PLUMB_INLINE vec3<F> texel_power(const RsmArgs& in, index_t<F> px, index_t<F> py, const vec3<F>& position, Tap& tap) {
    using N = number<F>;
    const F scale(in.texel_scale);
    if (in.light.directional > 0) {
        const F area = scale * scale;                                tap("area", area, "A, m2");
        return {F(in.light.intensity[0]) * area, F(in.light.intensity[1]) * area, F(in.light.intensity[2]) * area};
    }
    const F x = (N::from_index(px) + F(0.5f)) * scale - F(in.half_width);
    const F y = (N::from_index(py) + F(0.5f)) * scale - F(in.half_width);
    const F cos2 = F(1.0f) / (F(1.0f) + (x * x + y * y));
    const F cosine = sqrt(cos2);                                     tap("cos", cosine, "between w and the axis");
    const F dw = (scale * scale) * (cosine * cos2);                  tap("dw", dw, "(2 tan(a/2) / R)^2 cos^3, sr");
    const vec3<F> d{position.x - F(in.light.position[0]), position.y - F(in.light.position[1]),
                    position.z - F(in.light.position[2])};
    const vec3<F> intensity = light_intensity(in.light, cosine, dot3(d, d));
    tap("intensity", intensity, "I(w), W/sr");
    return {intensity.x * dw, intensity.y * dw, intensity.z * dw};
}

template <class F>
struct RsmTexel {
    vec4<F> position, normal, flux;
};

template <class F, class Tap>
PLUMB_INLINE RsmTexel<F> rsm(const RsmArgs& in, index_t<F> px, index_t<F> py, index_t<F> triangle, const vec2<F>& l,
                             Tap& tap) {
    const Surface<F> s = surface<F>(in.surfaces, triangle, l, tap);
    const F depth = linear_depth(in.eye, in.forward, s.position);    tap("depth", depth, "linear, from the light, m");
    const vec3<F> power = texel_power<F>(in, px, py, s.position, tap);
    tap("power", power, "through the texel, W");
    const vec3<F> flux{s.albedo.x * power.x, s.albedo.y * power.y, s.albedo.z * power.z};
    tap("flux", flux, "Phi = rho I(w) dw or rho E_perp A, W");
    return {vec4<F>(s.position, depth), vec4<F>(s.normal, F(1.0f)), vec4<F>(flux, F(0.0f))};
}

// What a later pass reads of a texel.
template <class F>
PLUMB_INLINE RsmTexel<F> stored(const RsmStore& store, const RsmTexel<F>& t) {
    return {vec4<F>(xyz<F>(quantised<F>(store.position, t.position)), stored_depth(store.depth, t.position.w)),
            vec4<F>(stored_normal<F>(store.normal, t.normal), t.normal.w),
            vec4<F>(xyz<F>(quantised<F>(store.flux, t.flux)), F(0.0f))};
}

}  // namespace plumb::raster
