// Irradiance in the air, from the grid of spatial receivers (IPR 4.1.2): the algorithm that volume.comp mirrors line by line.
//
//     E_d      irradiance along direction d of the six, between the eight places of the point's cell, each axis clamped at the grid
//     cube     E(n) = sum over axes a of n_a^2 E_(a, sign of n_a)                                     the ambient cube
//     linear   E(n) = max(0, sum_a n_a^2 (E_a+ + E_a-) / 2 + n_a (E_a+ - E_a-) / 2)    exact for radiance of degree 0 and 1
//     angles   E(n) = sum over d of w(d, n) E_d, w = 1 - 2 acos(max(0, d . n)) / pi                   as printed
//
// The light vector is where most irradiance comes from that reaches the surface (figure 4.3). With Y_d the sum of E_d's channels and
// S = sum Y_d:
//
//     D_a = (Y_a+ - Y_a-) / S                      of irradiance the vector of its flux: integral of L(w) w dw
//     V   = D + (least + max(0, -n . D)) n         turned into the hemisphere of n
//     V   = sum over d of w(d, n) Y_d d            `angles`: the figure's sum
//     l   = V / |V|                                and E(l), by the same form
//
// differs: IPR says "the direction of the maximal valid irradiance" and prints no equation. D is where E of `linear` is largest,
// and the direction of a single light exactly. `least` makes it n where light comes from everywhere alike.
#pragma once

#include "core/number.h"
#include "raster/project_kernel.h"

namespace plumb::probes {

// The twin's uniform block (std140).
struct VolumeUniforms {
    std::int32_t width, height;              // of the points
    std::int32_t count_x, count_y, count_z;  // places
    std::int32_t form;                       // 0 cube, 1 linear, 2 angles
    std::int32_t everywhere;                 // 1: of surfaces with a lightmap, too
    float least;                             // of the light vector along n, of S
    float origin[4], spacing[4];             // xyz m: of place (0, 0, 0); between places
};
static_assert(sizeof(VolumeUniforms) == 64);

struct VolumeView {
    VolumeUniforms u;
    const float* position;     // [height][width][4]: xyz m, world
    const float* normal;       // [height][width][4]: xyz unit; w 1: a point
    const float* lightmap_uv;  // [height][width][4]: x < 0: the surface has no lightmap
    const float* grid;         // [count_z][count_y][count_x][6][4]: W/m2, of +x -x +y -y +z -z
    float* irradiance;         // out: [height][width][4]: E(n), W/m2; w 1 where there is a point
    float* light;              // out: [height][width][4]: l; w as above
    float* from_light;         // out: [height][width][4]: E(l), W/m2; w as above
};

// Along one axis: the places before and behind x, and how far behind the first it is, in cells.
template <class F>
struct GridCell {
    index_t<F> first, next;
    F share;
};
template <class F>
PLUMB_INLINE GridCell<F> grid_cell(F x, float origin, float spacing, int count) {
    using I = index_t<F>;
    const F cells = clamp((x - F(origin)) / F(spacing), F(0.0f), F(float(count - 1)));
    const I first = max(I(0), min(raster::chosen(cells), I(count - 1)));
    return {first, min(first + I(1), I(count - 1)), cells - number<F>::from_index(first)};
}

// Of the two directions along one axis.
template <class F>
struct Sides {
    vec3<F> plus, minus;
};
template <class F>
struct SixSides {
    Sides<F> x, y, z;
};

// w(d, n) = 1 - 2 acos(max(0, c)) / pi, c = d . n. acos by Abramowitz and Stegun 4.4.46, to 2e-8, whose sqrt(1 - c) is taken as
// |d x n| / sqrt(1 + c): where both are nearly the same direction, 1 - c has no digits left. s2 = |d x n|^2.
template <class F>
PLUMB_INLINE F angle_weight(F c, F s2) {
    const F x = clamp(c, F(0.0f), F(1.0f));
    F p = F(-0.0012624911f) * x + F(0.0066700901f);
    p = p * x + F(-0.0170881256f);
    p = p * x + F(0.0308918810f);
    p = p * x + F(-0.0501743046f);
    p = p * x + F(0.0889789874f);
    p = p * x + F(-0.2145988016f);
    p = p * x + F(1.5707963050f);
    return select(c > F(0.0f), F(1.0f) - F(0.636619772f) * (sqrt(s2 / (F(1.0f) + x)) * p), F(0.0f));
}

// What the two sides of an axis count for; c along it, s2 the squares of the other two components.
template <class F>
struct SideWeights {
    F plus, minus;
};
template <class F>
PLUMB_INLINE SideWeights<F> side_weights(int form, F c, F s2) {
    if (form == 1) return {F(0.5f) * (c * c + c), F(0.5f) * (c * c - c)};
    if (form == 2) return {angle_weight<F>(c, s2), angle_weight<F>(-c, s2)};
    const mask_t<F> above = c > F(0.0f);
    return {select(above, c * c, F(0.0f)), select(above, F(0.0f), c * c)};
}

template <class F>
PLUMB_INLINE F towards(const SideWeights<F>& x, const SideWeights<F>& y, const SideWeights<F>& z, F xp, F xm, F yp, F ym, F zp, F zm) {
    const F sum = ((x.plus * xp + x.minus * xm) + (y.plus * yp + y.minus * ym)) + (z.plus * zp + z.minus * zm);
    return max(sum, F(0.0f));
}
// E(n), by the form.
template <class F>
PLUMB_INLINE vec3<F> irradiance_towards(int form, const SixSides<F>& e, const vec3<F>& n) {
    const SideWeights<F> x = side_weights<F>(form, n.x, n.y * n.y + n.z * n.z), y = side_weights<F>(form, n.y, n.x * n.x + n.z * n.z),
                         z = side_weights<F>(form, n.z, n.x * n.x + n.y * n.y);
    return {towards<F>(x, y, z, e.x.plus.x, e.x.minus.x, e.y.plus.x, e.y.minus.x, e.z.plus.x, e.z.minus.x),
            towards<F>(x, y, z, e.x.plus.y, e.x.minus.y, e.y.plus.y, e.y.minus.y, e.z.plus.y, e.z.minus.y),
            towards<F>(x, y, z, e.x.plus.z, e.x.minus.z, e.y.plus.z, e.y.minus.z, e.z.plus.z, e.z.minus.z)};
}

template <class F>
PLUMB_INLINE F channels(const vec3<F>& e) {
    return max(e.x + e.y + e.z, F(0.0f));
}
// The light vector of a point with normal n; n where there is no light.
template <class F, class Tap>
PLUMB_INLINE vec3<F> light_vector(int form, float least, const SixSides<F>& e, const vec3<F>& n, Tap& tap) {
    const SideWeights<F> x{channels<F>(e.x.plus), channels<F>(e.x.minus)}, y{channels<F>(e.y.plus), channels<F>(e.y.minus)},
        z{channels<F>(e.z.plus), channels<F>(e.z.minus)};
    const F sum = ((x.plus + x.minus) + (y.plus + y.minus)) + (z.plus + z.minus);
    tap("S", sum, "sum of all channels of all directions, W/m2");
    const F scale = F(1.0f) / max(sum, F(1e-30f));
    vec3<F> v{F(0.0f), F(0.0f), F(0.0f)};
    if (form == 2) {
        const SideWeights<F> wx = side_weights<F>(2, n.x, n.y * n.y + n.z * n.z), wy = side_weights<F>(2, n.y, n.x * n.x + n.z * n.z),
                             wz = side_weights<F>(2, n.z, n.x * n.x + n.y * n.y);
        v = {(wx.plus * x.plus - wx.minus * x.minus) * scale, (wy.plus * y.plus - wy.minus * y.minus) * scale,
             (wz.plus * z.plus - wz.minus * z.minus) * scale};
    } else {
        const vec3<F> d{(x.plus - x.minus) * scale, (y.plus - y.minus) * scale, (z.plus - z.minus) * scale};
        tap("D", d, "(Y_a+ - Y_a-) / S");
        const F along = F(least) + max(-dot3(n, d), F(0.0f));     tap("along", along, "least + max(0, -n . D)");
        v = {d.x + along * n.x, d.y + along * n.y, d.z + along * n.z};
    }
    tap("V", v, "towards the light, not of length 1");
    const F squared = dot3(v, v);
    const mask_t<F> is = squared > F(1e-12f);
    const F length = sqrt(select(is, squared, F(1.0f)));
    return select3<F>(is, {v.x / length, v.y / length, v.z / length}, n);
}

template <class F>
PLUMB_INLINE void add_weighed(vec3<F>& sum, F weight, const float* grid, index_t<F> at) {
    const vec3<F> e = xyz<F>(number<F>::fetch4(grid, at));
    sum.x = sum.x + weight * e.x;
    sum.y = sum.y + weight * e.y;
    sum.z = sum.z + weight * e.z;
}

template <class F, class Tap>
PLUMB_INLINE SixSides<F> grid_at(const VolumeView& in, const vec3<F>& x, Tap& tap) {
    using I = index_t<F>;
    const VolumeUniforms& u = in.u;
    const GridCell<F> cx = grid_cell<F>(x.x, u.origin[0], u.spacing[0], u.count_x);
    const GridCell<F> cy = grid_cell<F>(x.y, u.origin[1], u.spacing[1], u.count_y);
    const GridCell<F> cz = grid_cell<F>(x.z, u.origin[2], u.spacing[2], u.count_z);
    tap("cell", ivec2<I>{cx.first, cy.first}, "x and y of the cell's first place");
    tap("cell_z", cz.first, "z of the cell's first place");
    const vec3<F> zero{F(0.0f), F(0.0f), F(0.0f)};
    SixSides<F> e{{zero, zero}, {zero, zero}, {zero, zero}};
    for (int k = 0; k < 8; ++k) {
        tap.sample(k);
        const bool right = (k & 1) != 0, up = (k & 2) != 0, far = (k & 4) != 0;
        const F along_x = right ? cx.share : F(1.0f) - cx.share, along_y = up ? cy.share : F(1.0f) - cy.share,
                along_z = far ? cz.share : F(1.0f) - cz.share;
        const F weight = along_x * along_y * along_z;             tap("weight", weight, "trilinear share of the place");
        const I row = (far ? cz.next : cz.first) * I(u.count_y) + (up ? cy.next : cy.first);
        const I place = row * I(u.count_x) + (right ? cx.next : cx.first);
        tap("place", place, "x + count_x (y + count_y z)");
        const I at = place * I(6);
        add_weighed<F>(e.x.plus, weight, in.grid, at);
        add_weighed<F>(e.x.minus, weight, in.grid, at + I(1));
        add_weighed<F>(e.y.plus, weight, in.grid, at + I(2));
        add_weighed<F>(e.y.minus, weight, in.grid, at + I(3));
        add_weighed<F>(e.z.plus, weight, in.grid, at + I(4));
        add_weighed<F>(e.z.minus, weight, in.grid, at + I(5));
    }
    tap.sample(-1);
    tap("E_x_plus", e.x.plus, "W/m2"), tap("E_x_minus", e.x.minus, "W/m2");
    tap("E_y_plus", e.y.plus, "W/m2"), tap("E_y_minus", e.y.minus, "W/m2");
    tap("E_z_plus", e.z.plus, "W/m2"), tap("E_z_minus", e.z.minus, "W/m2");
    return e;
}

template <class F>
struct InVolume {
    vec4<F> irradiance, light, from_light;
    template <class Each>
    void components(Each each) const {
        for (const vec4<F>& v : {irradiance, light, from_light}) each(v.x), each(v.y), each(v.z), each(v.w);
    }
};

template <class F, class Tap>
PLUMB_INLINE InVolume<F> in_volume(const VolumeView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const VolumeUniforms& u = in.u;
    const I pixel = py * I(u.width) + px;
    const vec4<F> normal = N::fetch4(in.normal, pixel);
    const vec3<F> n = xyz<F>(normal);                             tap("n", n, "unit normal");
    const F uv = N::fetch4(in.lightmap_uv, pixel).x;              tap("uv", uv, "below 0: no lightmap");
    const mask_t<F> point = normal.w > F(0.0f);
    const mask_t<F> served = u.everywhere != 0 ? point : point & (uv < F(0.0f));
    tap("served", served, "whether the volume lights this surface");
    const vec4<F> nothing{F(0.0f), F(0.0f), F(0.0f), F(0.0f)};
    if (!any(served)) return {nothing, nothing, nothing};
    const vec3<F> x = xyz<F>(N::fetch4(in.position, pixel));      tap("x", x, "world, m");
    const SixSides<F> sides = grid_at<F>(in, x, tap);
    const vec3<F> e = irradiance_towards<F>(u.form, sides, n);    tap("E", e, "E(n), W/m2");
    const vec3<F> l = light_vector<F>(u.form, u.least, sides, n, tap);
    tap("l", l, "the light vector");
    const vec3<F> most = irradiance_towards<F>(u.form, sides, l); tap("E_l", most, "E(l), W/m2");
    const F w = select(served, F(1.0f), F(0.0f));
    const vec3<F> zero{F(0.0f), F(0.0f), F(0.0f)};
    return {vec4<F>(select3<F>(served, e, zero), w), vec4<F>(select3<F>(served, l, zero), w), vec4<F>(select3<F>(served, most, zero), w)};
}

struct VolumeKernel {
    using View = VolumeView;
    template <class F, class Tap>
    PLUMB_INLINE static InVolume<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return in_volume<F>(in, px, py, tap);
    }
    template <class F>
    static void store(const View& in, index_t<F> at, const InVolume<F>& v, mask_t<F> active) {
        number<F>::store4(in.irradiance, at, v.irradiance, active);
        number<F>::store4(in.light, at, v.light, active);
        number<F>::store4(in.from_light, at, v.from_light, active);
    }
};

}  // namespace plumb::probes
