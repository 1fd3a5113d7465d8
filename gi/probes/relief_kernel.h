// Normal maps and highlights by the light vector (IPR 4.1.2, 5.2.1.3, 5.2.1.6): the algorithm that relief.comp mirrors line by line.
//
//     E'  = E r                r = min(most, Y(E_v(n)) / Y(E_v(n_0)))       of surfaces whose E is that of their normal without map
//     L_s = k_s (rho(l) E_v(l) + sum over lamps k of rho(w_k) E_k)
//     rho(w) = (e + 2) / (2 pi) max(0, m . w)^e max(0, n . w)               m = 2 (n . v) n - v
//
// E_k is what lamp k sends across its rays, w_k the direction to it (direct_kernel.h), times its visibility. E_v is the volume's irradiance (volume_kernel.h), n the mapped and n_0 the plain normal, l the light vector, Y the sum of channels;
// k_s and e are Material::specular and ::exponent, Phong's lobe as the path tracer has it (gi/reference/bsdf_kernel.h).
//
// differs: IPR shows both and prints neither. The lightmap knows one normal; how much more or less arrives at another the volume
// tells, as a ratio, so that what the lightmap knows of shadows stays. The lobe sees all light arrive along l: of a single light that
// is what the path tracer has.
#pragma once

#include "core/detmath.h"
#include "core/number.h"
#include "raster/arriving_kernel.h"

namespace plumb::probes {

// The twin's uniform block (std140).
struct ReliefUniforms {
    std::int32_t width, height;
    std::int32_t maps;        // 1: normal maps
    std::int32_t highlights;  // 1: highlights
    float most;               // of the ratio
    std::int32_t lights;
    float padding[2];
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
    const raster::LightArgs* lights;  // [lights]
    const float* visibility;          // [lights][height][width]: 1 lit, 0 shadowed
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

// rho(w): what of irradiance that arrives along w the lobe sends to the viewer, 1/sr; n_v = n . v.
template <class F, class Tap>
PLUMB_INLINE F lobe_towards(const vec3<F>& n, const vec3<F>& v, F n_v, F exponent, const vec3<F>& w, Tap& tap) {
    // Not max(): of -0 and 0 a device may take either.
    const F n_w = dot3(n, w), facing = select(n_w > F(0.0f), n_w, F(0.0f));
    tap("facing", facing, "max(0, n . w)");
    // m . w = 2 (n . v)(n . w) - v . w
    const F mirrored = F(2.0f) * n_v * n_w - dot3(v, w);
    const F cosine = clamp(mirrored, F(0.0f), F(1.0f));           tap("mirrored", cosine, "m . w, 0 to 1");
    const F raised = detmath::pow(cosine, exponent);
    const F power = select((cosine > F(0.0f)) & (raised > F(1e-30f)), raised, F(0.0f));
    tap("power", power, "(m . w)^e; 0 below 1e-30");
    const F lobe = (exponent + F(2.0f)) * F(0.159154943f) * power * facing;
    tap("lobe", lobe, "(e + 2) / (2 pi) (m . w)^e (n . w), 1/sr");
    return lobe;
}

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
    const vec4<F> k = N::fetch4(in.specular, pixel);              tap("k", xyz<F>(k), "k_s"), tap("exponent", k.w, "e");
    const F exponent = max(k.w, F(0.0f)), n_v = dot3(n, v);
    const vec3<F> arriving = xyz<F>(N::fetch4(in.from_light, pixel));
    tap("E_l", arriving, "E_v(l), W/m2");
    vec3<F> sum = arriving * lobe_towards<F>(n, v, n_v, exponent, l, tap);
    for (int i = 0; i < u.lights; ++i) {
        tap.sample(i);
        const raster::Arriving<F> lamp = raster::arriving_from<F>(in.lights[i], x);
        tap("w", lamp.direction, "direction to the lamp");
        const F visibility = N::fetch(in.visibility, I(i * u.width * u.height) + pixel);
        tap("visibility", visibility, "VRSM Algorithm 4");
        const F lobe = lobe_towards<F>(n, v, n_v, exponent, lamp.direction, tap);
        const vec3<F> e = lamp.irradiance * (visibility * lobe);  tap("E_lobe", e, "V rho(w) E, W/(m2 sr)");
        sum = {sum.x + e.x, sum.y + e.y, sum.z + e.z};
    }
    tap.sample(-1);
    const mask_t<F> shown = point & (k.x + k.y + k.z > F(0.0f)) & (F(float(u.highlights)) > F(0.0f));
    const F w = select(point, F(1.0f), F(0.0f)), scale = w * r;
    const vec3<F> relieved{e.x * scale, e.y * scale, e.z * scale};
    const vec3<F> lit{k.x * sum.x, k.y * sum.y, k.z * sum.z}, dark{F(0.0f), F(0.0f), F(0.0f)};
    const vec3<F> glossy = select3<F>(shown, lit, dark);
    tap("relieved", relieved, "E r, W/m2"), tap("glossy", glossy, "L_s, W/(m2 sr)");
    return {vec4<F>(relieved, w), vec4<F>(glossy, w)};
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
