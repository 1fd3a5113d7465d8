// One bounce of diffuse light between what the camera sees: the algorithm that gather.comp mirrors line by line.
//
// Every coarse pixel is a small patch (ISR fig. 4.4). A pixel p gathers from N others X:
//
//     E = sum_X w_X F_pX B_X,    F_pX = cos_p cos_X A_X / (pi d^2 + A_X)                    ISR (25), (6), corrected
//
// with d from p to X, A_X the area of X's patch, and w_X such patches for which the sample stands: 1 on the grid, whose patches
// are squares of its spacing; of rings, whose patches are single pixels, as many pixels as its annulus has (README). Written
// out, the cosines are max(0, n_p.d) / |d| and max(0, -n_X.d) / |d|. The sum is divided by max(1, sum_X w_X F_pX).
//
// differs: ISR (25) multiplies F by the receiver's scalar reflectance and by 2 pi / N, has the unlit colour for B, and
// (6) no + A_X (variant `published`).
#pragma once

#include "core/hash.h"
#include "core/tile.h"
#include "gi/isr/source_planes.h"

namespace plumb::isr {

// Where none is given, or 0, it is the grid's: manifests of before do not have them.
PLUMB_INLINE float weight_of(const float* weights, int k) {
    const float given = weights ? weights[k] : 0.0f;
    return given == 0.0f ? 1.0f : given;
}

struct GatherInputsView {
    SampleUniforms u;
    const float* surface;           // [height][width] rgba32f
    const float* source_surface;    // [source_height][source_width] rgba32f: xyz unit normal, w depth; all 0: none
    const float* source_radiosity;  // xyz W/m2, w radiation mask
    const float* before;            // [height][width] rgba32f; null: all 0
    const std::int32_t* offsets;    // [samples][rotations]: dx in the lower 16 bits, dy in the upper 16
    const float* weights;           // [samples]: how many such form factors a sample stands for
    float* gathered;                // out: [height][width] rgba32f
    const float* shared;            // SourcePlanes
};

// What a sample X of the gather is.
template <class F>
struct Source {
    vec3<F> to;         // X - P, m
    F area;             // A_X, m2
    F weight;           // w_X
    vec3<F> normal;
    vec3<F> radiosity;  // W/m2
};

// No light is brighter than this, W/m2: infinity times a form factor of 0 would be no number.
inline constexpr float brightest = 1e30f;

template <class F>
PLUMB_INLINE vec3<F> light_of(const Surface<F>& s, const vec3<F>& radiosity) {
    const F most(brightest), zero(0.0f);
    const vec3<F> bounded{min(radiosity.x, most), min(radiosity.y, most), min(radiosity.z, most)};
    return select3<F>(is_covered(s), bounded, vec3<F>{zero, zero, zero});
}

// How far two rays lie apart at eye depth 1 m that are (dx, dy) pixels apart. T: a number or a lane's.
template <class T>
PLUMB_INLINE vec3<T> step_of(const SampleUniforms& u, T dx, T dy) {
    return {T(u.right.x) * dx + T(u.down.x) * dy, T(u.right.y) * dx + T(u.down.y) * dy,
            T(u.right.z) * dx + T(u.down.z) * dy};
}

// X - P = r_X z_X - r_P z_P, as (r_X - r_P) z_X + r_P (z_X - z_P): along a grazing view the difference of two rounded
// positions would hold little more than their roundings.
template <class F>
PLUMB_INLINE vec3<F> between(const Surface<F>& p, const vec3<F>& step, F depth) {
    const F further = depth - p.depth;
    return {step.x * depth + p.ray.x * further, step.y * depth + p.ray.y * further, step.z * depth + p.ray.z * further};
}

template <class F>
PLUMB_INLINE index_t<F> rotation_of(const SampleUniforms& u, index_t<F> px, index_t<F> py) {
    using I = index_t<F>;
    if (u.tile != 0) return tile_place(u.tile, px, py);
    return shift_right(pixel_hash(px, py, I(0), I(std::int32_t(u.seed))).x, 16) & I(u.rotations - 1);
}

// F_pX. Dividing twice keeps the range of a float, where d^4 would overflow from 4e9 m and vanish below 1e-10 m.
// by_angle: as if a sample, wherever it lies, had its share of the hemisphere, which the caller multiplies: cos_p / pi.
template <class F, bool published, class Tap>
PLUMB_INLINE F form_factor(const vec3<F>& n_p, const Source<F>& x, bool by_angle, Tap& tap) {
    const vec3<F> d = x.to;
    const F d2 = max(dot3(d, d), F(least_distance2));             tap("d2", d2, "|X - P|^2, m2");
    const F cos_p = max(F(0.0f), dot3(n_p, d));                   tap("cos_p", cos_p, "max(0, n_p.(X - P)), m");
    const F cos_x = max(F(0.0f), -dot3(x.normal, d));             tap("cos_x", cos_x, "max(0, n_X.(P - X)), m");
    if (published && by_angle) {
        const F seen = select(cos_x > F(0.0f), cos_p / sqrt(d2), F(0.0f));
        const F form = seen * F(0.318309886f);                    tap("form", form, "cos_p / pi where X faces P");
        return form;
    }
    const F cosines = cos_p * (F(1.0f) / d2) * cos_x;
    const F pi_d2 = F(3.14159265f) * d2;
    const F form = cosines * (x.area / (published ? pi_d2 : pi_d2 + x.area));
    tap("form", form, "ISR (6): cos_p cos_X A_X / (pi d^2 + A_X)");
    return form;
}

template <class F, bool published, class Sources, class Tap>
PLUMB_INLINE vec4<F> gather_by(const SampleUniforms& u, const Surface<F>& p, const vec4<F>& before, F mask,
                               const Sources& sources, Tap& tap) {
    const mask_t<F> covered = is_covered(p);
    const F zero(0.0f), one(1.0f);
    const vec3<F> none{zero, zero, zero};
    const F largest = published ? one : max(one, before.w);
    vec3<F> sum = published ? none : vec3<F>{before.x * largest, before.y * largest, before.z * largest};
    F forms = before.w, taken = zero;
    int k = 0;
    for (int ring = 1; ring <= u.rings; ++ring) {
        // ISR chapter 6: fewer samples for pixels far away.
        const F reach = ring <= u.far_rings ? F(3.4e38f) : F(u.full_reach);
        const mask_t<F> active = covered & (F(float(ring)) * p.depth <= reach);
        if (!any(active)) break;
        // Without a normal nothing is gathered.
        const vec3<F> n_p = select3<F>(active, p.normal, none);
        taken += select(active, F(float(8 * ring)), zero);
        for (int i = 0; i < 8 * ring; ++i, ++k) {
            tap.sample(k);
            const Source<F> x = sources.at(k, p, tap);
            tap("d", x.to, "X - P, m");
            tap("n_x", x.normal, "unit normal of X");
            tap("area", x.area, "A_X, m2");
            tap("radiosity", x.radiosity, "B_X, W/m2");
            const F form = x.weight * form_factor<F, published>(n_p, x, u.published == 3, tap);
            sum.x += form * x.radiosity.x;
            sum.y += form * x.radiosity.y;
            sum.z += form * x.radiosity.z;
            forms += form;                                        tap("forms", forms, "sum so far of w_X F_pX");
        }
    }
    tap.sample(-1);
    // N of (25) is of the samples that the pixel has: with fewer far away fewer than 4 k (k + 1).
    const F fewer = F(float(4 * u.rings * (u.rings + 1))) / max(taken, one);
    const F share = published ? mask * (u.published == 2 ? F(u.scale) : F(u.scale) * fewer) : one / max(one, forms);
    vec3<F> light = sum * share;
    if (published) light = light + xyz<F>(before);
    const vec3<F> irradiance = select3<F>(covered, light, none);
    tap("irradiance", irradiance, "sum w_X F_pX B_X / max(1, sum w_X F_pX), W/m2; ISR (25): rho_p 2 pi / N sum F_pX B_X");
    return vec4<F>(irradiance, select(covered, forms, zero));
}

// The samples of pixel (px, py), from the images. Beyond the border there is no surface.
template <class F>
struct SourceImages {
    const GatherInputsView& in;
    index_t<F> px, py, rotation;

    template <class Tap>
    PLUMB_INLINE Source<F> at(int k, const Surface<F>& p, Tap& tap) const {
        using N = number<F>;
        using I = index_t<F>;
        const SampleUniforms& u = in.u;
        const ivec2<I> offset = offset_of(N::fetch(in.offsets, rotation + I(k * u.rotations)));
        const ivec2<I> texel{px + offset.x + I(u.margin), py + offset.y + I(u.margin)};
        tap("texel", texel, "pixel of the sources");
        const mask_t<F> inside = in_range(texel.x, I(u.source_width)) & in_range(texel.y, I(u.source_height));
        tap("inside", inside, "1 if the sources have that pixel");
        const I i = select(inside, texel.y * I(u.source_width) + texel.x, I(0));
        const vec4<F> fetched = N::fetch4(in.source_surface, i);
        const F zero(0.0f);
        const vec4<F> surface{select(inside, fetched.x, zero), select(inside, fetched.y, zero),
                              select(inside, fetched.z, zero), select(inside, fetched.w, zero)};
        const Surface<F> s = surface_of<F>(u, px + offset.x, py + offset.y, surface);
        const vec3<F> step = step_of<F>(u, N::from_index(offset.x), N::from_index(offset.y));
        return {between(p, step, s.depth), area_of(u, s), F(weight_of(in.weights, k)), s.normal,
                light_of(s, xyz<F>(N::fetch4(in.source_radiosity, i)))};
    }
};

// The pixel (px, py), by whatever reads its samples: SourceImages, or a packet's view of planes (source_planes.h).
template <class F, class Sources, class Tap>
PLUMB_INLINE vec4<F> gather(const GatherInputsView& in, index_t<F> px, index_t<F> py, const Sources& sources, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const SampleUniforms& u = in.u;
    const I pixel = py * I(u.width) + px;
    const Surface<F> p = surface_of<F>(u, px, py, N::fetch4(in.surface, pixel));
    tap("p", p.position, "P, from the eye, m");
    tap("n_p", p.normal, "unit normal of P");
    const F zero(0.0f);
    const vec4<F> before = in.before ? N::fetch4(in.before, pixel) : vec4<F>{zero, zero, zero, zero};
    if (u.published != 0) {
        const I own = (py + I(u.margin)) * I(u.source_width) + px + I(u.margin);
        return gather_by<F, true>(u, p, before, N::fetch4(in.source_radiosity, own).w, sources, tap);
    }
    return gather_by<F, false>(u, p, before, zero, sources, tap);
}

struct GatherKernel {
    using View = GatherInputsView;
    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return gather<F>(in, px, py, SourceImages<F>{in, px, py, rotation_of<F>(in.u, px, py)}, tap);
    }
    static float* out(const View& in) { return in.gathered; }
    static std::size_t shared_floats(const View& in) { return SourcePlanes::floats(in.u, SourcePlanes::of_gather); }
    static int shared_rows(const View& in) { return in.u.source_height; }
};

}  // namespace plumb::isr
