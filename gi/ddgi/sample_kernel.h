// Irradiance at a point from the eight probes of its cell (DDGI 2019, section 5 and its listing): the algorithm that
// sample.comp mirrors line by line.
//
//     E(x, n) = scale sum_i w_i E_i(n) / sum_i w_i                 i: the corners of the grid's cell
//     w_i     = trilinear_i crushed(max(least, wrapped_i visible_i))
//     wrapped = ((1 + n . to_i) / 2)^2 + 0.2                       to_i: unit, from x to probe i
//     visible = 1 where r <= m1, else (s2 / (s2 + (r - m1)^2))^3   s2 = |m1^2 - m2|, the moments along the biased direction
//     r       = |x - p_i + bias|, bias = normal_bias n + view_bias v
//     crushed = w^3 / crush^2 below `crush`, else w
//
// differs: texels are fetched one by one and weighed in float; a GPU's filter has 8 bits of weight. Probe (x, y, z) is tile
// x + count_x y of row z, so that no index is divided. A point outside of the grid takes the cell at its edge.
#pragma once

#include "gi/ddgi/octahedral_kernel.h"
#include "raster/project_kernel.h"

namespace plumb::ddgi {

// The twin's uniform block (std140).
struct SampleUniforms {
    std::int32_t width, height;               // of the points
    std::int32_t side, depth_side;            // of tiles, without their gutters
    std::int32_t count_x, count_y, count_z;   // probes
    std::int32_t visibility;                  // 1: by moments
    std::int32_t wrapped;                     // 1: by the side of the surface that a probe lies on
    std::int32_t root;                        // 1: means are of square roots
    std::int32_t viewer;                      // 1: at `eye`; 0: the image `view` tells
    float scale;                              // of what texels hold, to W/m2
    float normal_bias, view_bias;             // m
    float crush, least_weight;
    float origin[4], spacing[4];              // xyz m: of probe (0, 0, 0); between probes
    float eye[4];                             // xyz m
};
static_assert(sizeof(SampleUniforms) == 112);

struct SampleView {
    SampleUniforms u;
    const float* position;    // [height][width][4]: xyz m, world
    const float* normal;      // [height][width][4]: xyz unit; 0: no point
    const float* view;        // [height][width][4]: xyz unit, towards the viewer
    const float* irradiance;  // [count_z (side + 2)][count_x count_y (side + 2)][4]
    const float* moments;     // [count_z (depth_side + 2)][count_x count_y (depth_side + 2)][4]: m, m2
    float* sampled;           // out: [height][width][4]: xyz W/m2; w: sum of the weights
};

// The four texels that a direction lies between, in any tile.
template <class F>
struct Footprint {
    ivec2<index_t<F>> first;
    vec2<F> fraction;  // weight of the right and of the lower ones
};
template <class F>
PLUMB_INLINE Footprint<F> footprint(const vec3<F>& direction, int side) {
    using raster::chosen;
    using N = number<F>;
    using I = index_t<F>;
    const vec2<F> e = octahedral_of(direction);
    const vec2<F> place{place_in_tile<F>(e.x, side), place_in_tile<F>(e.y, side)};
    const I x = chosen(place.x), y = chosen(place.y);
    const ivec2<I> first{max(I(0), min(x, I(side))), max(I(0), min(y, I(side)))};
    return {first, {place.x - N::from_index(first.x), place.y - N::from_index(first.y)}};
}

template <class F>
PLUMB_INLINE F between(F a, F b, F share) {
    return a + share * (b - a);
}
template <class F>
PLUMB_INLINE vec3<F> look_up(const float* atlas, int row_of_tiles, int side, const ivec2<index_t<F>>& tile,
                             const Footprint<F>& at) {
    using N = number<F>;
    using I = index_t<F>;
    const I width(row_of_tiles * (side + 2));
    const I i = (tile.y * I(side + 2) + at.first.y) * width + (tile.x * I(side + 2) + at.first.x);
    const vec4<F> a = N::fetch4(atlas, i), b = N::fetch4(atlas, i + I(1));
    const vec4<F> c = N::fetch4(atlas, i + width), d = N::fetch4(atlas, i + width + I(1));
    const F s = at.fraction.x, t = at.fraction.y;
    return {between(between(a.x, b.x, s), between(c.x, d.x, s), t), between(between(a.y, b.y, s), between(c.y, d.y, s), t),
            between(between(a.z, b.z, s), between(c.z, d.z, s), t)};
}

// Along one axis: the first probe of the cell that x lies in, and how far behind it x is, in cells.
template <class F>
struct Cell {
    index_t<F> first;
    F share;
};
template <class F>
PLUMB_INLINE Cell<F> cell_of(F x, float origin, float spacing, int count) {
    using raster::chosen;
    using I = index_t<F>;
    const F cells = clamp((x - F(origin)) / F(spacing), F(0.0f), F(float(count - 1)));
    const I first = max(I(0), min(chosen(cells), I(count - 1)));
    return {first, cells - number<F>::from_index(first)};
}

// Chebyshev's bound of how much of what a texel saw lies at r or beyond, cubed.
template <class F, class Tap>
PLUMB_INLINE F visible_share(const vec3<F>& moments, F r, Tap& tap) {
    const F variance = abs(moments.x * moments.x - moments.y);    tap("variance", variance, "|m1^2 - m2|, m2");
    const F behind = max(r - moments.x, F(0.0f));
    const F bound = variance / max(variance + behind * behind, F(1e-30f));
    tap("chebyshev", bound, "s2 / (s2 + (r - m1)^2)");
    return select(r <= moments.x, F(1.0f), bound * bound * bound);
}

template <class F, class Tap>
PLUMB_INLINE vec4<F> sample_probes(const SampleView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const SampleUniforms& u = in.u;
    const I pixel = py * I(u.width) + px;
    const vec3<F> x = xyz<F>(N::fetch4(in.position, pixel));      tap("x", x, "world, m");
    const vec3<F> n = xyz<F>(N::fetch4(in.normal, pixel));        tap("n", n, "unit normal of x");
    vec3<F> v{F(0.0f), F(0.0f), F(0.0f)};
    if (u.viewer != 0) {
        const vec3<F> d{F(u.eye[0]) - x.x, F(u.eye[1]) - x.y, F(u.eye[2]) - x.z};
        const F length = max(sqrt(dot3(d, d)), F(1e-18f));
        v = {d.x / length, d.y / length, d.z / length};
    } else {
        v = xyz<F>(N::fetch4(in.view, pixel));
    }
    tap("v", v, "unit, towards the viewer");
    const F along_n(u.normal_bias), along_v(u.view_bias);
    const vec3<F> bias{n.x * along_n + v.x * along_v, n.y * along_n + v.y * along_v, n.z * along_n + v.z * along_v};
    tap("bias", bias, "normal_bias n + view_bias v, m");
    const Cell<F> cx = cell_of<F>(x.x, u.origin[0], u.spacing[0], u.count_x);
    const Cell<F> cy = cell_of<F>(x.y, u.origin[1], u.spacing[1], u.count_y);
    const Cell<F> cz = cell_of<F>(x.z, u.origin[2], u.spacing[2], u.count_z);
    tap("cell", ivec2<I>{cx.first, cy.first}, "x and y of the cell's first probe");
    tap("cell_z", cz.first, "z of the cell's first probe");
    const Footprint<F> towards_n = footprint<F>(n, u.side);
    tap("texel", towards_n.first, "of a tile, upper left of the four around n");

    F total(0.0f);
    vec3<F> sum{F(0.0f), F(0.0f), F(0.0f)};
    for (int k = 0; k < 8; ++k) {
        tap.sample(k);
        const bool right = (k & 1) != 0, up = (k & 2) != 0, far = (k & 4) != 0;
        const I gx = min(cx.first + I(right ? 1 : 0), I(u.count_x - 1)), gy = min(cy.first + I(up ? 1 : 0), I(u.count_y - 1)),
                gz = min(cz.first + I(far ? 1 : 0), I(u.count_z - 1));
        const ivec2<I> tile{gx + gy * I(u.count_x), gz};          tap("tile", tile, "of probe i");
        const vec3<F> p{F(u.origin[0]) + N::from_index(gx) * F(u.spacing[0]), F(u.origin[1]) + N::from_index(gy) * F(u.spacing[1]),
                        F(u.origin[2]) + N::from_index(gz) * F(u.spacing[2])};
        tap("p", p, "p_i, m");
        const vec3<F> d{x.x - p.x, x.y - p.y, x.z - p.z};
        F weight(1.0f);
        if (u.wrapped != 0) {
            const F length = max(sqrt(dot3(d, d)), F(1e-18f));
            const F cosine = -(dot3(d, n) / length);              tap("cosine", cosine, "n . to_i");
            const F half = max(F(0.0001f), (cosine + F(1.0f)) * F(0.5f));
            weight = half * half + F(0.2f);                       tap("wrapped", weight, "((1 + n . to_i) / 2)^2 + 0.2");
        }
        if (u.visibility != 0) {
            const vec3<F> biased{d.x + bias.x, d.y + bias.y, d.z + bias.z};
            const F r = sqrt(dot3(biased, biased));               tap("r", r, "|x - p_i + bias|, m");
            const Footprint<F> at = footprint<F>(biased, u.depth_side);
            const vec3<F> moments = look_up<F>(in.moments, u.count_x * u.count_y, u.depth_side, tile, at);
            tap("moments", moments, "m1, m2: of distance along it, m, m2");
            const F visible = visible_share<F>(moments, r, tap);  tap("visible", visible, "1 where r <= m1, else cubed");
            weight = weight * visible;
        }
        weight = max(F(u.least_weight), weight);
        const F crushed = weight * (weight * weight * (F(1.0f) / (F(u.crush) * F(u.crush))));
        weight = select(weight < F(u.crush), crushed, weight);    tap("crushed", weight, "w^3 / crush^2 below crush");
        const F along_x = right ? cx.share : F(1.0f) - cx.share, along_y = up ? cy.share : F(1.0f) - cy.share,
                along_z = far ? cz.share : F(1.0f) - cz.share;
        weight = weight * (along_x * along_y * along_z);          tap("weight", weight, "w_i: times the trilinear share");
        vec3<F> e = look_up<F>(in.irradiance, u.count_x * u.count_y, u.side, tile, towards_n);
        if (u.root != 0) e = {sqrt(max(e.x, F(0.0f))), sqrt(max(e.y, F(0.0f))), sqrt(max(e.z, F(0.0f)))};
        tap("e", e, "E_i(n) as stored, or its root");
        sum.x = sum.x + weight * e.x;
        sum.y = sum.y + weight * e.y;
        sum.z = sum.z + weight * e.z;
        total = total + weight;                                   tap("total", total, "sum of the weights so far");
    }
    tap.sample(-1);
    const mask_t<F> weighed = total > F(0.0f), is = weighed & (dot3(n, n) > F(0.0f));
    const F divisor = select(weighed, total, F(1.0f));
    vec3<F> mean{sum.x / divisor, sum.y / divisor, sum.z / divisor};
    if (u.root != 0) mean = {mean.x * mean.x, mean.y * mean.y, mean.z * mean.z};
    const vec3<F> zero{F(0.0f), F(0.0f), F(0.0f)};
    const vec3<F> e = select3<F>(is, {mean.x * F(u.scale), mean.y * F(u.scale), mean.z * F(u.scale)}, zero);
    tap("irradiance", e, "scale sum w e / sum w, W/m2; 0 where no point is");
    return vec4<F>(e, select(is, total, F(0.0f)));
}

struct SampleKernel {
    using View = SampleView;
    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return sample_probes<F>(in, px, py, tap);
    }
    static float* out(const View& in) { return in.sampled; }
};

}  // namespace plumb::ddgi
