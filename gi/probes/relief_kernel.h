// Normal maps and highlights by the light vector (IPR 4.1.2, 5.2.1.3, 5.2.1.6): the algorithm that relief.comp mirrors line by line.
//
//     E'  = E r                r = min(most, Y(E_v(n)) / Y(E_v(n_0)))       of surfaces whose E is that of their normal without map
//     L_s = k_s (e + 2) / (2 pi) max(0, m . l)^e E_v(l) max(0, n . l)       m = 2 (n . v) n - v
//
// E_v is the volume's irradiance (volume_kernel.h), n the mapped and n_0 the plain normal, l the light vector, Y the sum of channels;
// k_s and e are Material::specular and ::exponent, Phong's lobe as the path tracer has it (gi/reference/bsdf_kernel.h).
//
// differs: IPR shows both and prints neither. The lightmap knows one normal; how much more or less arrives at another the volume
// tells, as a ratio, so that what the lightmap knows of shadows stays. The lobe sees all light arrive along l: of a single light that
// is what the path tracer has.
#pragma once

#include "core/detmath.h"
#include "core/number.h"

namespace plumb::probes {

// The twin's uniform block (std140).
struct ReliefUniforms {
    std::int32_t width, height;
    std::int32_t maps;        // 1: normal maps
    std::int32_t highlights;  // 1: highlights
    float most;               // of the ratio
    float padding[3];
    float eye[4];             // xyz m
};
static_assert(sizeof(ReliefUniforms) == 48);

struct ReliefView {
    ReliefUniforms u;
    const float* position;    // [height][width][4]: xyz m
    const float* normal;      // [height][width][4]: xyz unit, mapped; w 1: a point
    const float* irradiance;  // [height][width][4]: W/m2
    const float* mapped;      // [height][width][4]: of the volume, along the mapped normal, W/m2
    const float* plain;       // [height][width][4]: of the volume, along the plain normal, W/m2; w 0: `irradiance` is that of the mapped one
    const float* light;       // [height][width][4]: l
    const float* from_light;  // [height][width][4]: E_v(l), W/m2
    const float* specular;    // [height][width][4]: k_s, w: e
    float* relieved;          // out: [height][width][4]: E', W/m2; w 1 where there is a point
    float* glossy;            // out: [height][width][4]: L_s, W/(m2 sr); w as above
};

template <class F>
struct Relief {
    vec4<F> relieved, glossy;
    template <class Each>
    void components(Each each) const {
        for (const vec4<F>& v : {relieved, glossy}) each(v.x), each(v.y), each(v.z), each(v.w);
    }
};

template <class F, class Tap>
PLUMB_INLINE Relief<F> relief(const ReliefView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const ReliefUniforms& u = in.u;
    const I pixel = py * I(u.width) + px;
    const vec4<F> normal = N::fetch4(in.normal, pixel);
    const vec3<F> n = xyz<F>(normal);                             tap("n", n, "unit, mapped");
    const mask_t<F> point = normal.w > F(0.0f);
    const vec3<F> e = xyz<F>(N::fetch4(in.irradiance, pixel));    tap("E", e, "E, W/m2");
    const vec4<F> mapped = N::fetch4(in.mapped, pixel), plain = N::fetch4(in.plain, pixel);
    const F above = mapped.x + mapped.y + mapped.z, below = plain.x + plain.y + plain.z;
    tap("above", above, "Y(E_v(n))"), tap("below", below, "Y(E_v(n_0))");
    const mask_t<F> known = (plain.w > F(0.0f)) & (below > F(1e-30f));
    const F ratio = min(above / select(known, below, F(1.0f)), F(u.most));
    const F r = u.maps != 0 ? select(known, ratio, F(1.0f)) : F(1.0f);
    tap("r", r, "ratio of irradiance");

    const vec3<F> x = xyz<F>(N::fetch4(in.position, pixel));      tap("x", x, "world, m");
    const vec3<F> d{F(u.eye[0]) - x.x, F(u.eye[1]) - x.y, F(u.eye[2]) - x.z};
    const F length = max(sqrt(dot3(d, d)), F(1e-18f));
    const vec3<F> v{d.x / length, d.y / length, d.z / length};    tap("v", v, "unit, towards the viewer");
    const vec3<F> l = xyz<F>(N::fetch4(in.light, pixel));         tap("l", l, "the light vector");
    // Not max(): of -0 and 0 a device may take either.
    const F n_l = dot3(n, l), facing = select(n_l > F(0.0f), n_l, F(0.0f));
    tap("facing", facing, "max(0, n . l)");
    // m . l = 2 (n . v)(n . l) - v . l
    const F mirrored = F(2.0f) * dot3(n, v) * n_l - dot3(v, l);
    const F cosine = clamp(mirrored, F(0.0f), F(1.0f));           tap("mirrored", cosine, "m . l, 0 to 1");
    const vec4<F> k = N::fetch4(in.specular, pixel);              tap("k", xyz<F>(k), "k_s"), tap("exponent", k.w, "e");
    const F exponent = max(k.w, F(0.0f));
    const F raised = detmath::pow(cosine, exponent);
    const F power = select((cosine > F(0.0f)) & (raised > F(1e-30f)), raised, F(0.0f));
    tap("power", power, "(m . l)^e; 0 below 1e-30");
    const F lobe = (exponent + F(2.0f)) * F(0.159154943f) * power * facing;
    tap("lobe", lobe, "(e + 2) / (2 pi) (m . l)^e (n . l), 1/sr");
    const vec3<F> arriving = xyz<F>(N::fetch4(in.from_light, pixel));
    tap("E_l", arriving, "E_v(l), W/m2");
    const F shown = select(point, F(u.highlights != 0 ? 1.0f : 0.0f), F(0.0f)) * lobe;
    const F w = select(point, F(1.0f), F(0.0f)), scale = w * r;
    return {vec4<F>(e.x * scale, e.y * scale, e.z * scale, w),
            vec4<F>(k.x * arriving.x * shown, k.y * arriving.y * shown, k.z * arriving.z * shown, w)};
}

struct ReliefKernel {
    using View = ReliefView;
    template <class F, class Tap>
    PLUMB_INLINE static Relief<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return relief<F>(in, px, py, tap);
    }
    template <class F>
    static void store(const View& in, index_t<F> at, const Relief<F>& r, mask_t<F> active) {
        number<F>::store4(in.relieved, at, r.relieved, active);
        number<F>::store4(in.glossy, at, r.glossy, active);
    }
};

}  // namespace plumb::probes
