// Shadow tests against a light's depth map: the algorithm that shadow.comp mirrors line by line.
//
//     visibility = share of the k x k texels around the projection of x for which    d_p <= d_map + bias
//                                                                                              VRSM Algorithm 4
//
// A kernel of one texel is the hard test. Where the map holds nothing, and outside of it, nothing is known to stand in
// the way: lit.
//
// The soft tests take what surrounds the projection:
//
//     pcf    the share of a square of k x k texels, centred at the projection, that is not shadowed; k = 1: bilinear
//     esm    exp(-c max(0, d_p - d_map - bias)) of the four texels around, weighed bilinearly      ISR (30), Listing 8
//
// What shadows, of hard, density and pcf, is `test`. By planes a texel with the point m and the normal n_m on it shadows
// the point x with the normal n, turned to the light, where
//
//     n.(m - x) > least + s |m - x|                 m lies over the plane of x, not along it
//     n_m.(m - x) > least                           x lies under the plane of m
//
// A plane hides nothing of itself, whatever its slope and however far the texel; and of two that meet in a corner neither
// hides the other. `plane` asks the first line alone. s is for normals that are not the surface's own, and 0 beyond `reach`, as
// far along the surface as the texels lie that are read. A normal map bends n by more: of a picture the first line is asked of
// the plane of the pixels around x, too (surface_normal()), and both have to lie under m.
//
// By depth it is d_p > d_map + bias, with a bias that follows the surface. Across one texel of footprint f (m, across the
// light's axis a) the depth of a plane with normal n changes by f sqrt(1 - (n.a)^2) / |n.r|, where r is the ray to the
// point, scaled to depth 1. Half a texel in both directions needs 1/sqrt(2) of that; slope_bias = 1 leaves a margin for
// rounding. A wider kernel reaches farther: the host multiplies slope_bias by the reach.
//
// differs: the printed listing of VRSM has a constant bias, and compares `depth - zBias >= p.depth` with negative z,
// which holds for the samples in shadow; its text blends the count as the share that is lit (variant `published`).
// differs: Listing 8 of ISR does not divide by w, lacks the half texel between a texel's corner and its centre,
// multiplies d_p - d_map by the cosine at the surface, and has no bias (variant `published` of pcf and esm).
#pragma once

#include "core/detmath.h"
#include "core/number.h"
#include "raster/project_kernel.h"
#include "raster/surface_kernel.h"

namespace plumb::direct {

enum class Soft : int { none, pcf, esm };
enum class Test : int { depth, plane, planes };

// The twin's uniform block (std140).
struct ShadowUniforms {
    raster::Projection map;
    float eye[4];           // xyz: where the light's linear depth starts
    float forward[4];       // xyz: unit, the light's axis
    float footprint_scale;  // footprint of a texel = footprint_scale d + footprint_base, m
    float footprint_base;
    float bias;             // m
    float slope_bias;       // texels
    float max_slope;
    float perspective;      // 1: spot, point; 0: directional
    std::int32_t kernel;    // texels a side
    float samples;          // kernel^2
    std::int32_t published; // 1: Algorithm 4, or Listing 8, as printed
    std::int32_t face;      // of a point light: this map serves the points of that face alone; -1: a map serves all
    std::int32_t width, height;
    std::int32_t soft;      // Soft
    float c;                // 1/m: of ISR (30)
    std::int32_t test;      // Test
    float least_sine;       // s: of the angle over the plane of x; with what positions are rounded by
    float rounding;         // of stored positions, relative
    std::int32_t beside;    // 1: the plane of the pixels around x has to lie under m, too
    std::int32_t padding[2];
};
static_assert(sizeof(ShadowUniforms) == 176);

struct ShadowInputsView {
    ShadowUniforms u;
    const float* position;      // [height][width] rgba32f: xyz world, m
    const float* normal;        // [height][width] rgba32f: xyz unit
    const float* map_position;  // [size][size] rgba32f: xyz world, w linear depth, m; 0 where nothing is
    const float* map_normal;    // [size][size] rgba32f: xyz unit, to the light; of test = planes, else it may be null
    float* visibility;          // [height][width] r32f, out: 1 lit, 0 shadowed
};

// True where this map serves x: the points of one face have no other map, so that no seam is left or counted twice.
template <class F>
PLUMB_INLINE mask_t<F> serves(const ShadowUniforms& u, const vec3<F>& x) {
    const vec3<F> from_eye{x.x - F(u.eye[0]), x.y - F(u.eye[1]), x.z - F(u.eye[2])};
    return raster::face_of<F>(from_eye) == index_t<F>(u.face);
}

// A point as its light sees it.
template <class F>
struct Receiver {
    vec3<F> from_eye;  // m
    F d_p;             // linear depth, m
    F bias;            // m
    vec3<F> x;         // m
    vec3<F> n;         // unit, turned to the light
    index_t<F> px, py; // of the picture
    vec3<F> surface;   // of the pixels around x, unit, turned to the light; made where it is `asked` for
    bool asked;
    F least;           // m: no farther from a plane is on it
    F reach;           // m, along the surface
};

// How deep x lies, and how much depth changes across a texel there.
template <class F, class Tap>
PLUMB_INLINE Receiver<F> receiver(const ShadowUniforms& u, index_t<F> px, index_t<F> py, const vec3<F>& x, const vec3<F>& n,
                                  Tap& tap) {
    const vec3<F> axis{F(u.forward[0]), F(u.forward[1]), F(u.forward[2])};
    const vec3<F> from_eye{x.x - F(u.eye[0]), x.y - F(u.eye[1]), x.z - F(u.eye[2])};
    const F d_p = dot3(from_eye, axis);                            tap("d_p", d_p, "linear depth of x, m");
    const F n_a = dot3(n, axis);
    const F n_r = u.perspective > 0.0f ? dot3(n, from_eye) / max(d_p, F(u.map.least_w)) : n_a;
    const F across = sqrt(max(F(0.0f), F(1.0f) - n_a * n_a));
    const F slope = min(across / max(abs(n_r), F(1e-6f)), F(u.max_slope));
    const F footprint = F(u.footprint_scale) * d_p + F(u.footprint_base);
    const F bias = F(u.bias) + F(u.slope_bias) * footprint * slope;
    tap("bias", bias, "bias + slope_bias f sqrt(1 - (n.a)^2) / |n.r|, m");
    const F turned = select(n_r > F(0.0f), F(-1.0f), F(1.0f));     tap("turned", turned, "-1 where n looks away from the light");
    const F moved = abs(n.x * x.x) + abs(n.y * x.y) + abs(n.z * x.z);
    const F least = F(u.bias) + F(u.rounding) * moved;
    tap("least", least, "bias + rounding (|n_x x| + |n_y y| + |n_z z|), m");
    const F reach = F(u.slope_bias) * footprint * min(F(1.0f) / max(abs(n_r), F(1e-6f)), F(u.max_slope));
    tap("reach", reach, "slope_bias f / |n.r|, m");
    return {from_eye, d_p, bias, x, n * turned, px, py, n, false, least, reach};
}

// What one axis of the picture tells of the surface of x: the step to the next pixel where that and the one behind it go on as
// the surface does, so that x - 2 a + b is less than half of a - x; to the right (down) if they do, else to the left (up).
template <class F>
struct Step {
    vec3<F> along;  // m
    mask_t<F> known;
};
template <class F, class At>
PLUMB_INLINE Step<F> step_along(const vec3<F>& x, const At& at) {
    auto goes_on = [&](int way) -> Step<F> {
        const vec3<F> a = at(way), b = at(2 * way);
        const vec3<F> along{a.x - x.x, a.y - x.y, a.z - x.z};
        const vec3<F> bend{(b.x - a.x) - along.x, (b.y - a.y) - along.y, (b.z - a.z) - along.z};
        return {along, dot3(bend, bend) < F(0.25f) * dot3(along, along)};
    };
    const Step<F> first = goes_on(1), other = goes_on(-1);
    const mask_t<F> known = first.known | other.known;
    return {select3<F>(first.known, first.along, other.along), known};
}

// The normal of the surface that x lies on, turned to the light, from the pixels around: a normal map does not bend it. Where
// no two pixels beside x go on as its surface does, in a row or in a column, it is n. Beyond the border the last pixel stands
// in, which goes on as nothing does.
template <class F, class Tap>
PLUMB_INLINE vec3<F> surface_normal(const ShadowInputsView& in, const Receiver<F>& r, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const I right(in.u.width - 1), bottom(in.u.height - 1);
    auto position = [&](I column, I row) { return xyz<F>(N::fetch4(in.position, row * I(in.u.width) + column)); };
    const Step<F> row = step_along<F>(r.x, [&](int d) { return position(min(max(r.px + I(d), I(0)), right), r.py); });
    const Step<F> column = step_along<F>(r.x, [&](int d) { return position(r.px, min(max(r.py + I(d), I(0)), bottom)); });
    const vec3<F> plane = raster::normalised(raster::face_normal(row.along, column.along));
    const vec3<F> surface = select3<F>(row.known & column.known, plane, r.n);
    const vec3<F> axis{F(in.u.forward[0]), F(in.u.forward[1]), F(in.u.forward[2])};
    const F along_ray = in.u.perspective > 0.0f ? dot3(surface, r.from_eye) : dot3(surface, axis);
    const F turned = select(along_ray > F(0.0f), F(-1.0f), F(1.0f));
    const vec3<F> facing = surface * turned;
    tap("surface", facing, "normal of the surface by the pixels around x, turned to the light");
    return facing;
}

template <class F>
struct MapTexel {
    mask_t<F> inside;  // whether the map has it
    index_t<F> index;  // 0 where not
    vec3<F> m;         // world, m
    F depth;           // m; 0 where nothing is
};

template <class F, class Tap>
PLUMB_INLINE MapTexel<F> texel_at(const ShadowInputsView& in, ivec2<index_t<F>> texel, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const I size(in.u.map.size);
    if (in.u.face >= 0) {
        // Beyond the border lies another face; the border's texels stand in for it.
        const I last(in.u.map.size - 1);
        texel = {min(max(texel.x, I(0)), last), min(max(texel.y, I(0)), last)};
    }
    tap("texel", texel, "of the map");
    const mask_t<F> inside = in_range(texel.x, size) & in_range(texel.y, size);
    tap("inside", inside, "1 if the map has that texel; if not, what follows is texel 0, and is lit");
    const I index = select(inside, texel.y * size + texel.x, I(0));
    const vec4<F> stored = N::fetch4(in.map_position, index);
    tap("d_map", stored.w, "linear depth in the map, m; 0 where nothing is");
    return {inside, index, xyz<F>(stored), stored.w};
}

// Whether what the map holds there hides x from the light.
template <class F, class Tap>
PLUMB_INLINE mask_t<F> shadows(const ShadowInputsView& in, Receiver<F>& r, const MapTexel<F>& t, Tap& tap) {
    const ShadowUniforms& u = in.u;
    const mask_t<F> known = t.inside & (t.depth > F(0.0f));
    if (u.test == int(Test::depth)) return known & (r.d_p > t.depth + r.bias);
    const vec3<F> v{t.m.x - r.x.x, t.m.y - r.x.y, t.m.z - r.x.z};
    const F height = dot3(r.n, v);                                 tap("height", height, "n.(m - x): over the plane of x, m");
    const F away = sqrt(dot3(v, v));
    const F on_it = r.least + select(away <= r.reach, F(u.least_sine), F(u.rounding)) * away;
    tap("on_it", on_it, "least + s |m - x|, m; beyond reach s is the rounding alone");
    mask_t<F> above = known & (height > on_it);
    // Most texels lie on the plane of x.
    if (!any(above)) return above;
    if (u.beside != 0) {
        if (!r.asked) r.surface = surface_normal<F>(in, r, tap), r.asked = true;
        const F over = dot3(r.surface, v);                         tap("over", over, "m over the plane of the pixels around x, m");
        above = above & (over > on_it);
    }
    if (u.test == int(Test::plane)) return above;
    const vec3<F> n_m = xyz<F>(number<F>::fetch4(in.map_normal, t.index));
    const F below = dot3(n_m, v);                                  tap("below", below, "n_m.(m - x): x under the plane of m, m");
    return above & (below > r.least);
}

// The hard test, and the shadow density.
template <class F, class Tap>
PLUMB_INLINE F share_lit(const ShadowInputsView& in, const vec3<F>& x, Receiver<F>& r, Tap& tap) {
    using I = index_t<F>;
    const ShadowUniforms& u = in.u;
    const ivec2<I> centre = raster::project<F>(u.map, x, tap);     tap("centre", centre, "texel of the projection");
    F count(0.0f);
    const int first = -(u.kernel / 2);
    for (int k = 0; k < u.kernel * u.kernel; ++k) {
        tap.sample(k);
        // VRSM Algorithm 4: centre + (i, j), from -kernel/2.
        const MapTexel<F> t =
            texel_at<F>(in, {centre.x + I(first + k % u.kernel), centre.y + I(first + k / u.kernel)}, tap);
        if (u.published != 0) {
            const mask_t<F> counted = t.inside & (-t.depth - F(u.bias) >= -r.d_p);
            count += select(counted, F(1.0f), F(0.0f));
            tap("count", count, "Algorithm 4 as printed: z_map - zBias >= z_p, z = -depth");
        } else {
            count += select(shadows<F>(in, r, t, tap), F(0.0f), F(1.0f));
            tap("count", count, "so far, of texels that do not shadow x");
        }
    }
    tap.sample(-1);
    const F visibility = count / F(u.samples);
    tap("visibility", visibility, "VRSM Algorithm 4: count / kernel^2");
    return visibility;
}

// Where x falls on the map, in texels whose centres are whole numbers. As printed, corners are, and nothing is divided
// by w: 1/2 + clip / 2, times the size.
template <class F, class Tap>
PLUMB_INLINE vec2<F> place_of(const ShadowUniforms& u, const vec3<F>& x, Tap& tap) {
    if (u.published == 0) {
        const vec2<F> corner = raster::projected<F>(u.map, x, tap);
        const vec2<F> place{corner.x - F(0.5f), corner.y - F(0.5f)};
        tap("place", place, "the projection, texel centres at whole numbers");
        return place;
    }
    auto row = [&](const float* m) { return F(m[0]) * x.x + F(m[1]) * x.y + F(m[2]) * x.z + F(m[3]); };
    const F low(u.map.low), high(u.map.high);
    // The rows are those of (clip + w) size / 2.
    const F undivided = (F(1.0f) - row(u.map.to_texel_w)) * F(0.5f * float(u.map.size));
    const vec2<F> place{clamp(row(u.map.to_texel_x) + undivided, low, high),
                        clamp(row(u.map.to_texel_y) + undivided, low, high)};
    tap("place", place, "Listing 8 as printed: (1/2 + clip / 2) size");
    return place;
}

// What Listing 8 multiplies the difference of depths by.
template <class F, class Tap>
PLUMB_INLINE F printed_cosine(const ShadowUniforms& u, const vec3<F>& n, const Receiver<F>& r, Tap& tap) {
    const vec3<F> axis{F(u.forward[0]), F(u.forward[1]), F(u.forward[2])};
    const F inverse = F(1.0f) / sqrt(max(dot3(r.from_eye, r.from_eye), F(1e-37f)));
    const F towards = u.perspective > 0.0f ? dot3(n, r.from_eye) * inverse : dot3(n, axis);
    const F cosine = clamp(-towards, F(0.0f), F(1.0f));
    tap("cosine", cosine, "Listing 8: saturate(dot(-n, normalize(p - light)))");
    return cosine;
}

// PCF and ESM: the (k + 1)^2 texels that a square of k x k texels around the projection touches, weighed by the share of
// each that it covers. Of k = 1: four, bilinearly.
template <class F, class Tap>
PLUMB_INLINE F soft_shadow(const ShadowInputsView& in, const vec3<F>& x, const vec3<F>& n, Receiver<F>& r,
                           Tap& tap) {
    using raster::chosen;
    using N = number<F>;
    using I = index_t<F>;
    const ShadowUniforms& u = in.u;
    const int k = u.kernel, before = k / 2;
    const vec2<F> centre = place_of<F>(u, x, tap);
    // An even square begins half a texel beside one whose middle is a texel's centre.
    const F shift(k % 2 == 0 ? 0.5f : 0.0f);
    const vec2<F> place{centre.x + shift, centre.y + shift};
    const ivec2<I> first{chosen(place.x), chosen(place.y)};
    const vec2<F> fraction{place.x - N::from_index(first.x), place.y - N::from_index(first.y)};
    tap("fraction", fraction, "weight of the last column and row of texels; of the first, 1 - it");
    const F factor = u.published != 0 ? printed_cosine<F>(u, n, r, tap) : F(1.0f);
    if (u.published != 0) r.bias = F(u.soft == int(Soft::pcf) ? u.bias : 0.0f);

    F sum(0.0f), upper(0.0f);
    for (int j = 0; j <= k; ++j) {
        F row(0.0f), left(0.0f);
        for (int i = 0; i <= k; ++i) {
            tap.sample(j * (k + 1) + i);
            const MapTexel<F> t = texel_at<F>(in, {first.x + I(i - before), first.y + I(j - before)}, tap);
            F lit;
            if (u.soft == int(Soft::pcf)) {
                lit = select(shadows<F>(in, r, t, tap), F(0.0f), F(1.0f));
            } else {
                const F behind = max(F(0.0f), (r.d_p - t.depth) - r.bias) * factor;
                tap("behind", behind, "max(0, d_p - d_map - bias), m; as printed times the cosine");
                lit = select(t.inside & (t.depth > F(0.0f)), detmath::exp(-(F(u.c) * behind)), F(1.0f));
            }
            tap("lit", lit, "pcf: not shadowed; esm: exp(-c behind), ISR (30)");
            // The first of a row counts by 1 - fraction, the last by fraction.
            if (i == 0) left = lit;
            row = i < k ? row + lit : row + fraction.x * (lit - left);
        }
        if (j == 0) upper = row;
        sum = j < k ? sum + row : sum + fraction.y * (row - upper);
    }
    tap.sample(-1);
    const F visibility = sum / F(u.samples);
    tap("visibility", visibility, "mean over the square; Listing 8: bilinear");
    return visibility;
}

template <class F, class Tap>
PLUMB_INLINE F shadow(const ShadowInputsView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    const index_t<F> pixel = py * index_t<F>(in.u.width) + px;
    const vec3<F> x = xyz<F>(N::fetch4(in.position, pixel));       tap("x", x, "world, m");
    const vec3<F> n = xyz<F>(N::fetch4(in.normal, pixel));         tap("n", n, "unit normal of x");
    Receiver<F> r = receiver<F>(in.u, px, py, x, n, tap);
    if (in.u.soft == int(Soft::none)) return share_lit<F>(in, x, r, tap);
    return soft_shadow<F>(in, x, n, r, tap);
}

struct ShadowKernel {
    using View = ShadowInputsView;
    template <class F, class Tap>
    PLUMB_INLINE static F item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return shadow<F>(in, px, py, tap);
    }
    static float* out(const View& in) { return in.visibility; }
    template <class F>
    PLUMB_INLINE static mask_t<F> writes(const View& in, index_t<F> px, index_t<F> py) {
        if (in.u.face < 0) return index_t<F>(in.u.face) < index_t<F>(0);
        return serves<F>(in.u, xyz<F>(number<F>::fetch4(in.position, py * index_t<F>(in.u.width) + px)));
    }
};

}  // namespace plumb::direct
