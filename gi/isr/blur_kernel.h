// The blur of the coarse result along rows or columns (ISR 4.2, Listing 3): the algorithm that blur.comp mirrors line
// by line.
//
//     E = sum_i w_i E_i / sum_i w_i,    i = -radius .. radius along a row or a column
//
//     gaussian    w_i = g_i where i has a surface, else 0; beyond the border there is none
//     edge_aware  w_i = g_i max(0, 1 - q^2) max(0, n . n_i),  q = n . (r_i z_i - r z) / (0.02 z)
//     published   w_i = g_i everywhere, the border's pixel standing for what lies beyond; not divided by the sum
//
// g a Gaussian whose sum is 1. All four components are blurred: irradiance and accessibility. r z is where a pixel's surface
// is as seen from the eye (surface_kernel.h), so that q is the distance of i from the plane of the pixel's own surface: a
// floor seen at grazing incidence is no edge.
//
// One template serves two ways to reach a pixel's neighbours: Texels is BlurImageTexels, the images as they are bound,
// or a packet's view of them taken apart into planes (blur_isa.cpp).
#pragma once

#include <cstddef>

#include "core/number.h"

namespace plumb::isr {

enum class BlurKind : int { gaussian, edge_aware, published };

// As far from the pixel's plane, in shares of its depth, a neighbour is another surface. Ours, as is the whole of edge_aware.
inline constexpr float edge_distance = 0.02f;

// The twin's uniform block (std140).
struct BlurUniforms {
    glm::vec4 right, down, origin;  // xyz f_u, f_v, f_o, m at eye depth 1: of edge_aware alone
    std::int32_t width, height;
    std::int32_t radius;    // coarse pixels
    std::int32_t vertical;  // 0: along rows, 1: along columns
    std::int32_t kind;      // BlurKind
    std::int32_t padding[3];
};
static_assert(sizeof(BlurUniforms) == 80);

// Images are [height][width] rgba32f.
struct BlurInputsView {
    BlurUniforms u;
    const float* lit;      // xyz irradiance, W/m2, w accessibility
    const float* surface;  // xyz unit normal, w linear eye depth, m (read by edge_aware alone); all 0 where none is
    const float* spatial;  // [2 radius + 1]
    float* blurred;        // out: as lit
};

// A pixel as the blur reads it.
template <class F>
struct BlurTexel {
    vec3<F> irradiance;  // W/m2
    F accessibility;
    F covered;           // 1 where a surface is, else 0
    vec3<F> normal;      // unit, or all 0
    F depth;             // m
};

// The pixels before and after (px, py), from the images.
template <class F>
struct BlurImageTexels {
    const BlurInputsView& in;
    index_t<F> px, py;

    // d pixels further along the row or the column.
    PLUMB_INLINE BlurTexel<F> at(int d) const {
        using N = number<F>;
        using I = index_t<F>;
        const I x = in.u.vertical != 0 ? px : px + I(d), y = in.u.vertical != 0 ? py + I(d) : py;
        const mask_t<F> inside = in_range(x, I(in.u.width)) & in_range(y, I(in.u.height));
        const I cx = min(max(x, I(0)), I(in.u.width - 1)), cy = min(max(y, I(0)), I(in.u.height - 1));
        const I i = cy * I(in.u.width) + cx;
        const vec4<F> lit = N::fetch4(in.lit, i), surface = N::fetch4(in.surface, i);
        const vec3<F> n = xyz<F>(surface);
        const mask_t<F> covered = inside & (dot3(n, n) > F(0.0f));
        const F zero(0.0f);
        const vec3<F> normal = select3<F>(inside, n, vec3<F>{zero, zero, zero});
        return {xyz<F>(lit), lit.w, select(covered, F(1.0f), zero), normal, surface.w};
    }
};

// n . r of the pixels along a row or a column: `own` of the pixel itself, `each` more for every pixel further.
template <class F>
struct Facing {
    F own, each;  // m at eye depth 1
};

template <class F>
PLUMB_INLINE Facing<F> facing_of(const BlurUniforms& u, index_t<F> px, index_t<F> py, const vec3<F>& n) {
    using N = number<F>;
    const F x = N::from_index(px), y = N::from_index(py);
    const vec3<F> right{F(u.right.x), F(u.right.y), F(u.right.z)}, down{F(u.down.x), F(u.down.y), F(u.down.z)};
    const vec3<F> ray{right.x * x + down.x * y + F(u.origin.x), right.y * x + down.y * y + F(u.origin.y),
                      right.z * x + down.z * y + F(u.origin.z)};
    return {dot3(n, ray), dot3(n, u.vertical != 0 ? down : right)};
}

// max(0, 1 - q^2) max(0, n . n_i), i being d pixels away. Polynomials that reach 0: beyond an edge nothing is left.
template <class F, class Tap>
PLUMB_INLINE F edge_weight(const BlurTexel<F>& c, const Facing<F>& f, const BlurTexel<F>& t, int d, Tap& tap) {
    // As a difference of n . r_i z_i and n . r z it would lose the digits that they share.
    const F away = f.own * (t.depth - c.depth) + (f.each * F(float(d))) * t.depth;
    tap("away", away, "n . (r_i z_i - r z), m: from the plane of the pixel's surface");
    // Below 1e-37 m the quotient would overflow.
    const F q = away / max(F(edge_distance) * c.depth, F(1e-37f));
    const F of_plane = max(F(0.0f), F(1.0f) - q * q);
    tap("of_plane", of_plane, "max(0, 1 - q^2), q = away / (0.02 z)");
    const F of_normal = max(F(0.0f), dot3(c.normal, t.normal));
    tap("of_normal", of_normal, "max(0, n . n_i)");
    return of_plane * of_normal;
}

template <class F, BlurKind kind, class Texels, class Tap>
PLUMB_INLINE vec4<F> blur_by(const BlurUniforms& u, const float* spatial, index_t<F> px, index_t<F> py, const Texels& texels,
                             Tap& tap) {
    const BlurTexel<F> c = texels.at(0);
    tap("n", c.normal, "unit normal");
    tap("depth", c.depth, "m");
    const Facing<F> facing = facing_of<F>(u, px, py, c.normal);
    vec3<F> sum{F(0.0f), F(0.0f), F(0.0f)};
    F open(0.0f), total(0.0f);
    for (int k = 0; k <= u.radius + u.radius; ++k) {
        tap.sample(k);
        const BlurTexel<F> t = texels.at(k - u.radius);
        tap("irradiance_i", t.irradiance, "W/m2");
        tap("accessibility_i", t.accessibility, "1 open .. 0 closed");
        F weight(spatial[k]);
        if (kind == BlurKind::gaussian) weight = weight * t.covered;
        if (kind == BlurKind::edge_aware) weight = weight * t.covered * edge_weight(c, facing, t, k - u.radius, tap);
        tap("weight", weight, "ISR 4.2: Gaussian; 0 where no surface is");
        sum.x += weight * t.irradiance.x;
        sum.y += weight * t.irradiance.y;
        sum.z += weight * t.irradiance.z;
        open += weight * t.accessibility;
        total += weight;
        tap("total", total, "sum of the weights so far");
    }
    tap.sample(-1);
    vec3<F> irradiance = sum;
    F accessibility = open;
    if (kind != BlurKind::published) {
        const F divisor = select(total > F(0.0f), total, F(1.0f));
        const mask_t<F> covered = c.covered > F(0.0f);
        const F zero(0.0f);
        const vec3<F> mean{sum.x / divisor, sum.y / divisor, sum.z / divisor};
        irradiance = select3<F>(covered, mean, vec3<F>{zero, zero, zero});
        accessibility = select(covered, open / divisor, F(1.0f));
    }
    tap("irradiance", irradiance, "sum / total; 0 where no surface is, W/m2");
    tap("accessibility", accessibility, "sum / total; 1 where no surface is");
    return vec4<F>(irradiance, accessibility);
}

template <class F, class Texels, class Tap>
PLUMB_INLINE vec4<F> blur(const BlurUniforms& u, const float* spatial, index_t<F> px, index_t<F> py, const Texels& texels,
                          Tap& tap) {
    if (u.kind == int(BlurKind::gaussian)) return blur_by<F, BlurKind::gaussian>(u, spatial, px, py, texels, tap);
    if (u.kind == int(BlurKind::edge_aware)) return blur_by<F, BlurKind::edge_aware>(u, spatial, px, py, texels, tap);
    return blur_by<F, BlurKind::published>(u, spatial, px, py, texels, tap);
}

// The images around a band of rows, taken apart into planes: a packet then reads its neighbours side by side. What lies
// beyond the border is in the padding: no surface, or (published) the border's pixel.
struct BlurPlanes {
    enum : int { red, green, blue, open, covered, normal_x, normal_y, normal_z, depth, count };
    static constexpr int padding = 32;  // floats before the first pixel and after the last; the largest radius is 32

    float* planes;   // [row][count][stride]: rows first .. last, and of a vertical blur a radius before and after
    int stride;      // floats
    int first_row;   // of the image: may lie above it

    static int stride_of(int width) { return ((width + 15) & ~15) + 2 * padding; }
    static int halo(const BlurUniforms& u) { return u.vertical != 0 ? u.radius : 0; }
    static std::size_t floats(const BlurUniforms& u, int rows) {
        return std::size_t(rows + 2 * halo(u)) * count * std::size_t(stride_of(u.width));
    }
    float* at(int plane, int y) const {
        return planes + (std::ptrdiff_t(y - first_row) * count + plane) * stride + padding;
    }
};

struct BlurKernel {
    using View = BlurInputsView;
    static constexpr int band = 32;  // a vertical blur also reads the rows around them

    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return blur<F>(in.u, in.spatial, px, py, BlurImageTexels<F>{in, px, py}, tap);
    }
    static float* out(const View& in) { return in.blurred; }
    static std::size_t scratch(const View& in, int rows) { return BlurPlanes::floats(in.u, rows); }
};

}  // namespace plumb::isr
