// Rays of rough reflections: the algorithm that lobe.comp mirrors line by line.
//
// Of what arrives along w_i a surface with Phong's lobe (Lafortune and Willems 1994, (4)) sends to the eye
//
//     f(w_i) N.w_i L(w_i),    f = k (n + 2)/(2 pi) max(0, r.w_i)^n        r: w_o mirrored, k: `specular` of the material
//
// and w_i is drawn with the density p = (n + 1)/(2 pi) (r.w_i)^n about r, as the path tracer does, so that what a ray meets
// weighs
//
//     f N.w_i / p = k w,    w = (n + 2)/(n + 1) max(0, N.w_i)
//
// k is left to screen.mirror. A ray that leaves below the surface weighs 0. Block 0 of the sheet has the mirror's ray.
//
// 1 - cos = -expm1(log(1 - u) / (n + 1)): for large n a cosine next to 1 would keep few digits.
#pragma once

#include "core/detmath.h"
#include "core/hash.h"
#include "gi/reference/warp_kernel.h"
#include "gi/screen/mirrored_ray_kernel.h"
#include "gi/screen/sheet_kernel.h"

namespace plumb::screen {

// The twin's uniform block (std140).
struct LobeUniforms {
    float eye[4];                // xyz world, m
    std::int32_t columns, rows;  // pixels of the picture
    std::int32_t across;         // pictures beside each other
    std::int32_t rays;           // of a lobe
    std::int32_t seed;
    std::int32_t width, height;  // pixels of the sheet
    std::int32_t padding;
};
static_assert(sizeof(LobeUniforms) == 48);

// All but the output [rows][columns] rgba32f.
struct LobeInputsView {
    LobeUniforms u;
    const float* position;  // xyz world, m
    const float* normal;    // xyz unit; all 0: no surface
    const float* mirror;    // w 0: no mirror
    const float* lobe;      // xyz reflectance, w exponent; xyz 0: none
    float* ray;             // out: [height][width] rgba32f: xyz unit direction, w weight; 0: none
};

// A direction about z: cos = (1 - u_1)^(1 / (n + 1)).
template <class F, class Tap>
PLUMB_INLINE vec3<F> about_z(F u_1, F u_2, F exponent, Tap& tap) {
    const F one(1.0f), two(2.0f);
    const F versine = -detmath::expm1(detmath::log(one - u_1) / (exponent + one));
    tap("versine", versine, "1 - cos of the angle to r");
    const F sine = sqrt(max(versine * (two - versine), F(0.0f)));
    const vec2<F> around = reference::on_circle<F>(u_2);
    return {sine * around.x, sine * around.y, one - versine};
}

template <class F, class Tap>
PLUMB_INLINE vec4<F> lobe(const LobeInputsView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const LobeUniforms& u = in.u;
    const F zero(0.0f), one(1.0f), two(2.0f);
    const I across = times_in<F>(px, u.columns), down = times_in<F>(py, u.rows), block = down * I(u.across) + across;
    const I x = px - across * I(u.columns), y = py - down * I(u.rows), pixel = y * I(u.columns) + x;
    const vec3<F> p = xyz<F>(N::fetch4(in.position, pixel));      tap("p", p, "world, m");
    const vec3<F> n = xyz<F>(N::fetch4(in.normal, pixel));        tap("n", n, "unit normal of p");
    const MirroredRay<F> about = mirrored_ray<F>(p, n, from(u.eye, p), u.eye, tap);
    const vec4<F> of = N::fetch4(in.lobe, pixel);                 tap("exponent", of.w, "n of the lobe");
    const Hash3<I> hash = pixel_hash(x, y, block, I(u.seed));
    const vec3<F> local = about_z<F>(unit_float<F>(hash.x), unit_float<F>(hash.y), of.w, tap);
    const reference::Basis<F> basis = reference::basis_of<F>(about.r);
    const vec3<F> a = basis.tangent, b = basis.bitangent, r = about.r;
    const vec3<F> drawn{a.x * local.x + b.x * local.y + r.x * local.z, a.y * local.x + b.y * local.y + r.y * local.z,
                        a.z * local.x + b.z * local.y + r.z * local.z};
    const F cosine = dot3(n, drawn);                              tap("rises", cosine, "N.w_i");
    const F weight = (of.w + two) / (of.w + one) * max(cosine, zero);
    tap("weight", weight, "(n + 2)/(n + 1) max(0, N.w_i)");
    const mask_t<F> mirror = N::fetch4(in.mirror, pixel).w > zero, rough = (of.x > zero) | (of.y > zero) | (of.z > zero);
    const mask_t<F> first = block == I(0), seen = about.cosine < zero;
    const mask_t<F> leaves = seen & ((first & mirror) | (!first & rough & (cosine > zero) & (block <= I(u.rays))));
    const vec3<F> none{zero, zero, zero};
    const vec3<F> ray = select3<F>(leaves, select3<F>(first, r, drawn), none);
    const F of_ray = select(leaves, select(first, one, weight), zero);
    tap("ray", ray, "w_i, unit");
    tap("share", of_ray, "w; of a mirror 1");
    return vec4<F>(ray, of_ray);
}

struct LobeKernel {
    using View = LobeInputsView;
    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return lobe<F>(in, px, py, tap);
    }
    static float* out(const View& in) { return in.ray; }
};

}  // namespace plumb::screen
