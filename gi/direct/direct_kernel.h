// Direct irradiance from point-like and directional lights: the algorithm that direct.comp mirrors line by line.
//
//     E = sum over lights  V  I(w) max(0, n . w) / |y - x|^2          spot, point: y the light, w the direction to it
//     E = sum over lights  V  E_perp max(0, -n . direction)           directional
//
// Of a light that ends at its radius (ISR (16)) I(w) holds d^2: light_kernel.h.
//
// Shadow density (VRSM 4.3, fig. 4.3), where it is asked for: alpha = the mean of V over the lights that shine, 0 where
// none does or nothing is seen. As printed the density is all there is of direct light: E = pi alpha, so that a surface of
// reflectance rho sends rho alpha.
#pragma once

#include "core/number.h"
#include "raster/light_kernel.h"

namespace plumb::direct {

// The twin's uniform block (std140).
struct DirectUniforms {
    std::int32_t lights;
    std::int32_t width, height;
    std::int32_t density;  // 1: w is the shadow density, 2: so is E / pi, 0: w is 0
};
static_assert(sizeof(DirectUniforms) == 16);

struct DirectInputsView {
    DirectUniforms u;
    const float* position;            // [height][width] rgba32f: xyz world, m
    const float* normal;              // [height][width] rgba32f: xyz unit, w 1; all 0 where nothing is
    const raster::LightArgs* lights;  // [lights]
    const float* visibility;          // [lights][height][width]: 1 lit, 0 shadowed
    float* irradiance;                // [height][width] rgba32f, out: xyz W/m2, w shadow density
};

// A light of denormals alone does not: a device may take them for 0.
inline bool shines(const raster::LightArgs& light) {
    return light.intensity[0] >= 0x1p-126f || light.intensity[1] >= 0x1p-126f || light.intensity[2] >= 0x1p-126f;
}

template <class F, class Tap>
PLUMB_INLINE vec4<F> direct(const DirectInputsView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const I pixel = py * I(in.u.width) + px;
    const vec3<F> x = xyz<F>(N::fetch4(in.position, pixel));        tap("x", x, "world, m");
    const vec4<F> normal = N::fetch4(in.normal, pixel);
    const vec3<F> n = xyz<F>(normal);                               tap("n", n, "unit normal of x");

    vec3<F> irradiance{F(0.0f), F(0.0f), F(0.0f)};
    F lit(0.0f), alpha(0.0f);
    int shining = 0;
    for (int k = 0; k < in.u.lights; ++k) {
        tap.sample(k);
        const raster::LightArgs& light = in.lights[k];
        const vec3<F> axis{F(light.direction[0]), F(light.direction[1]), F(light.direction[2])};
        vec3<F> e;
        if (light.directional > 0.0f) {
            const F cos_theta = max(F(0.0f), -dot3(n, axis));       tap("cos_theta", cos_theta, "-n . direction");
            e = vec3<F>{F(light.intensity[0]), F(light.intensity[1]), F(light.intensity[2])} * cos_theta;
        } else {
            const vec3<F> v{F(light.position[0]) - x.x, F(light.position[1]) - x.y, F(light.position[2]) - x.z};
            const F d2 = dot3(v, v);
            const F inverse = F(1.0f) / sqrt(max(d2, F(1e-37f)));
            const vec3<F> w = v * inverse;                          tap("w", w, "direction to the light");
            const F cos_theta = max(F(0.0f), dot3(n, w));           tap("cos_theta", cos_theta, "n . w");
            const vec3<F> intensity = raster::light_intensity(light, -dot3(w, axis), d2);
            tap("intensity", intensity, "I(w), W/sr");
            e = intensity * (cos_theta * inverse * inverse);
        }
        const F visibility = N::fetch(in.visibility, I(k * in.u.width * in.u.height) + pixel);
        tap("visibility", visibility, "VRSM Algorithm 4");
        e = e * visibility;                                         tap("E", e, "V I(w) max(0, n.w) / d^2, W/m2");
        irradiance.x += e.x;
        irradiance.y += e.y;
        irradiance.z += e.z;
        if (in.u.density > 0 && shines(light)) {
            lit += visibility;
            ++shining;
        }
    }
    tap.sample(-1);
    if (in.u.density > 0) {
        const F mean = lit / F(float(shining > 1 ? shining : 1));
        alpha = select(normal.w > F(0.0f), mean, F(0.0f));
        tap("density", alpha, "VRSM 4.3: mean visibility of the lights that shine");
    }
    if (in.u.density > 1) irradiance = vec3<F>{F(1.0f), F(1.0f), F(1.0f)} * (F(3.14159274f) * alpha);
    tap("irradiance", irradiance, "sum over lights; printed: pi density; W/m2");
    return vec4<F>(irradiance, alpha);
}

struct DirectKernel {
    using View = DirectInputsView;
    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return direct::direct<F>(in, px, py, tap);
    }
    static float* out(const View& in) { return in.irradiance; }
};

}  // namespace plumb::direct
