// One-bounce indirect irradiance from a reflective shadow map: the algorithm that gather_disc.glsl and
// gather_all.comp mirror line by line.
//
// Every texel p of the map is a small diffuse light at x_p with normal n_p that reflects the flux Phi_p. It sends to
// the shading point x with normal n the irradiance
//
//     E_p = Phi_p / pi  max(0, n_p . (x - x_p)) max(0, n . (x_p - x)) / |x - x_p|^4                       VRSM (3.2)
//
// differs: the printed equation has no 1/pi (variant `published`), and takes a sample for a point (share_of_disc()).
#pragma once

#include "core/hash.h"
#include "core/number.h"
#include "core/tile.h"
#include "gi/rsm/texels_kernel.h"

namespace plumb::rsm {

// The disc's uniform block (std140).
struct GatherUniforms {
    raster::Projection map;
    float least_distance2;  // m2: the floor of |x - x_p|^2
    float scale;            // 1/pi; published: 1
    std::int32_t samples;
    std::int32_t rotations; // a power of two
    std::int32_t width;     // of the image of shading points
    std::int32_t height;
    std::uint32_t seed;
    std::int32_t reach;     // texels: the pattern's largest |dx| or |dy|
    float texel_area[4];    // a texel at x_p covers h^3 / |n_p . (xyz - w x_p)| m2, h = map.to_texel_w . (x_p, 1)
    float sample_area;      // 1/pi: a sample is as large as its texels; 0: a point, as printed
    std::int32_t tile;      // side of the tile of pixels that deals out rotations; 0: a hash of the pixel does
    std::int32_t padding[2];
};
static_assert(sizeof(GatherUniforms) == 128);

// One invocation's inputs. Component is float or Half: the storage of the map's records. A device binds the map as three
// images; where nobody lends its records, they are made of these.
template <class Component>
struct GatherInputsView {
    GatherUniforms u;
    const float* position;        // [height][width] rgba32f: xyz world, m
    const float* normal;          // [height][width] rgba32f: xyz unit
    const float* rsm_position;    // [size][size] rgba32f: xyz world, m
    const float* rsm_normal;      // [size][size] rgba32f: xyz unit; w: 1 where there is a surface
    const float* rsm_flux;        // [size][size] rgba32f: xyz W
    const Component* records;     // [size][size] records: the three of them
    const std::int32_t* offsets;  // [samples][rotations]: whole texels, dx in the lower 16 bits, dy in the upper 16
    const float* positions;       // continuous: [samples][rotations][2]: dx, dy in texels
    const float* weights;         // [samples]: texels that a sample stands for
    float* irradiance;            // [height][width] rgba32f, out: W/m2
};

struct AllInputsView {
    GatherUniforms u;       // of its map the size alone is read, of its pattern nothing
    const float* position;  // as above
    const float* normal;
    const float* rsm_position;
    const float* rsm_normal;
    const float* rsm_flux;
    const float* records;
    const Half* half_records;  // where they are lent, `records` is made of them
    float* irradiance;
};

// The geometry of VRSM (3.2), everything but the flux: 1/m2. Dividing twice by d^2 keeps the range of a float, where
// d^4 would overflow from 4e9 m and vanish below 1e-10 m.
template <class F, class Tap>
PLUMB_INLINE F form(const vec3<F>& x, const vec3<F>& n, const vec3<F>& x_p, const vec3<F>& n_p, F least_distance2,
                    Tap& tap) {
    const vec3<F> d = x_p - x;
    const F d2 = dot3(d, d);                                      tap("d2", d2, "|x_p - x|^2, m2");
    const F cos_p = max(F(0.0f), -dot3(n_p, d));
    tap("cos_p", cos_p, "VRSM (3.2): max(0, n_p.(x - x_p)), m");
    const F cos_x = max(F(0.0f), dot3(n, d));
    tap("cos_x", cos_x, "VRSM (3.2): max(0, n.(x_p - x)), m");
    const F inverse = F(1.0f) / max(d2, least_distance2);
    const F form = (cos_p * inverse) * (cos_x * inverse);
    tap("form", form, "VRSM (3.2): cos_p cos_x / d^4, 1/m2");
    return form;
}

// How much of what `weight` pixel lights send from one point a disc as large as their texels does. From a disc of area a,
// seen along its axis from a distance d, comes the form factor a / (a + pi d^2) in place of a / (pi d^2): with A of a texel
//
//     share = d^2 / (d^2 + weight A / pi),     A = h^3 / |n_p . (texel_area.xyz - texel_area.w x_p)|
//
// Both are held against that normal, so that a surface along the light's rays, whose texels are as large as one likes, is
// divided by nothing near 0.
//
// differs: VRSM takes pixel lights for "infinitely small in area size" (3.1), whatever number of them a sample stands for.
template <class F, class Uniforms, class Tap>
PLUMB_INLINE F share_of_disc(const Uniforms& u, const vec3<F>& x, const vec3<F>& x_p, const vec3<F>& n_p, F weight, Tap& tap) {
    const vec3<F> d = x_p - x;
    const float *row = u.map.to_texel_w, *area = u.texel_area;
    const F w = F(row[0]) * x_p.x + F(row[1]) * x_p.y + F(row[2]) * x_p.z + F(row[3]);
    // Beyond 1e12 m its cube would leave the range of a float.
    const F h = clamp(w, F(u.map.least_w), F(1e12f));
    const vec3<F> seen{F(area[0]) - F(area[3]) * x_p.x, F(area[1]) - F(area[3]) * x_p.y, F(area[2]) - F(area[3]) * x_p.z};
    const F facing = abs(dot3(n_p, seen));
    // No product of infinity and 0.
    const F point = min(clamp(dot3(d, d), F(u.least_distance2), F(1e37f)) * facing, F(1e37f));
    const F disc = point + (weight * F(u.sample_area) * h) * (h * h);
    const F share = point / max(disc, F(1e-37f));
    tap("share", share, "d^2 / (d^2 + w A / pi): of a disc of the sample's texels over as many pixel lights in one point");
    return share;
}

// What the samples of a pixel share.
template <class F, bool continuous>
struct ProjectedPoint {
    vec3<F> x, n;
    TexelsOf<F, continuous> texels;
    index_t<F> rotation;
    mask_t<F> near;  // where samples may meet the map
};

// Uniforms: GatherUniforms or PathsUniforms.
template <class I, class Uniforms>
PLUMB_INLINE I rotation_of(const Uniforms& u, const I& px, const I& py) {
    if (u.tile != 0) return tile_place(u.tile, px, py);
    return shift_right(pixel_hash(px, py, I(0), I(std::int32_t(u.seed))).x, 16) & I(u.rotations - 1);
}

template <class F, bool continuous, class Component, class Tap>
PLUMB_INLINE ProjectedPoint<F, continuous> projected_point(const GatherInputsView<Component>& in, const index_t<F>& px,
                                                       const index_t<F>& py, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const GatherUniforms& u = in.u;
    const I pixel = py * I(u.width) + px;
    const vec3<F> x = xyz<F>(N::fetch4(in.position, pixel));      tap("x", x, "world, m");
    const vec3<F> n = xyz<F>(N::fetch4(in.normal, pixel));        tap("n", n, "unit normal of x");
    const TexelsOf<F, continuous> texels(u.map, x, tap);
    const I rotation = rotation_of(u, px, py);
    tap("rotation", rotation, "row of the table of offsets");
    return {x, n, texels, rotation, texels.near(u.map.size, u.reach)};
}

// What a sample reads.
template <class F>
struct MapSample {
    mask_t<F> inside;
    Record<F> p;
    ivec2<index_t<F>> texel;  // for taps
};

// The row of a sample in tables [samples][rotations], of which its own part begins at `first`.
template <class Row>
PLUMB_INLINE Row row_of(const Row& rotation, int first) {
    return rotation + Row(first);
}

// Whether sample k need not be read: packets of rotation_packets.h know of some that add 0. They have functions of the same
// names as these two.
template <class Row>
PLUMB_INLINE bool adds_nothing(const Row&, int) {
    return false;
}

template <class F, class View, class Point, class Row, class Tap>
PLUMB_INLINE MapSample<F> map_sample(const View& in, const Point& point, const Row& rotation, int k, Tap& tap) {
    using I = index_t<F>;
    const I size(in.u.map.size);
    const ivec2<I> texel = point.texels.texel(in, row_of(rotation, k * in.u.rotations), tap);
    // A sample outside the map contributes nothing, and the divisor stays.
    const mask_t<F> inside = in_range(texel.x, size) & in_range(texel.y, size);
    return {inside, number<F>::fetch_record(in.records, select(inside, texel.y * size + texel.x, I(0))), texel};
}

// Adds the samples of the disc (Dachsbacher and Stamminger 2005; LRA 4.3.3), N around the projection of x, each with the
// number of texels that it stands for. `rotation` is the point's own or what rotation_packets.h knows of it.
//
// differs: samples come from a table of rotations, and unless `continuous` they are whole texels away from the one rounded
// projection (texels_kernel.h). LRA's listing also takes the receiver's normal in both cosines.
template <class F, bool continuous, class Component, class Row, class Tap>
PLUMB_INLINE void gather_samples(const GatherInputsView<Component>& in, const ProjectedPoint<F, continuous>& point,
                                 const Row& rotation, vec3<F>& sum, Tap& tap) {
    const GatherUniforms& u = in.u;
    for (int k = 0; k < u.samples; ++k) {
        if (adds_nothing(rotation, k)) continue;
        tap.sample(k);
        const MapSample<F> sample = map_sample<F>(in, point, rotation, k, tap);
        tap("texel", sample.texel, "LRA 4.3.3: p + r (xi1 sin 2 pi xi2, xi1 cos 2 pi xi2)");
        tap("inside", sample.inside, "1 if the map has that texel; if not, what follows is texel 0 with weight 0");
        const vec3<F> x_p = xyz<F>(sample.p.a), n_p = xyz<F>(sample.p.b), flux = xyz<F>(sample.p.c);
        const F weight = select(sample.inside, F(in.weights[k]), F(0.0f));
        tap("x_p", x_p, "world, m");
        tap("n_p", n_p, "unit normal of x_p");
        tap("flux", flux, "Phi_p, W");
        tap("weight", weight, "texels: 2 pi r^2 xi1 / N; published: xi1^2, normalised");

        F share(1.0f);
        if (u.sample_area > 0.0f) share = share_of_disc(u, point.x, x_p, n_p, weight, tap);
        const F g = form(point.x, point.n, x_p, n_p, F(u.least_distance2), tap) * (weight * share);
        sum.x += flux.x * g;
        sum.y += flux.y * g;
        sum.z += flux.z * g;
        tap("sum", sum, "sum so far of weight Phi_p form, W/m2");
    }
}

template <class F, bool continuous, class Tap>
PLUMB_INLINE vec3<F> irradiance_of(const GatherUniforms& u, const ProjectedPoint<F, continuous>& point,
                                   const vec3<F>& sum, Tap& tap) {
    tap.sample(-1);
    const vec3<F> zero{F(0.0f), F(0.0f), F(0.0f)};
    const vec3<F> irradiance = select3<F>(point.near, sum * F(u.scale), zero);
    tap("irradiance", irradiance, "E = sum / pi, W/m2");
    return irradiance;
}

// The whole of a pixel. rotation_packets.h puts the same parts together.
template <class F, bool continuous = false, class Component, class Tap>
PLUMB_INLINE vec3<F> gather_disc(const GatherInputsView<Component>& in, index_t<F> px, index_t<F> py, Tap& tap) {
    const auto point = projected_point<F, continuous>(in, px, py, tap);
    vec3<F> sum{F(0.0f), F(0.0f), F(0.0f)};
    if (any(point.near)) gather_samples<F, continuous>(in, point, point.rotation, sum, tap);
    return irradiance_of<F, continuous>(in.u, point, sum, tap);
}

// Every texel of the map, without visibility: what the disc gather estimates. Rows are summed one by one and then
// added, so that the error grows with the map's side, not with its area.
template <class F, class Tap>
PLUMB_INLINE vec3<F> gather_all(const AllInputsView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const GatherUniforms& u = in.u;
    const I pixel = py * I(u.width) + px;
    const vec3<F> x = xyz<F>(N::fetch4(in.position, pixel));      tap("x", x, "world, m");
    const vec3<F> n = xyz<F>(N::fetch4(in.normal, pixel));        tap("n", n, "unit normal of x");

    vec3<F> sum{F(0.0f), F(0.0f), F(0.0f)};
    for (int row = 0; row < u.map.size; ++row) {
        vec3<F> row_sum{F(0.0f), F(0.0f), F(0.0f)};
        for (int column = 0; column < u.map.size; ++column) {
            const int texel = row * u.map.size + column;              tap.sample(texel);
            const float* p = in.records + record_stride * std::ptrdiff_t(texel);
            const vec3<F> x_p{F(p[0]), F(p[1]), F(p[2])}, n_p{F(p[4]), F(p[5]), F(p[6])};
            const vec3<F> flux{F(p[8]), F(p[9]), F(p[10])};
            tap("x_p", x_p, "world, m");
            tap("n_p", n_p, "unit normal of x_p");
            tap("flux", flux, "Phi_p, W");
            const F g = form(x, n, x_p, n_p, F(u.least_distance2), tap);
            row_sum.x += flux.x * g;
            row_sum.y += flux.y * g;
            row_sum.z += flux.z * g;
            tap("row_sum", row_sum, "sum over this row of Phi_p form, W/m2");
        }
        sum.x += row_sum.x;
        sum.y += row_sum.y;
        sum.z += row_sum.z;                                       tap("sum", sum, "sum over the rows so far, W/m2");
    }
    tap.sample(-1);
    const vec3<F> irradiance = sum * F(u.scale);                  tap("irradiance", irradiance, "E = sum / pi, W/m2");
    return irradiance;
}

// Rows are shaded in an order of their own: rotation_packets.h.
template <bool continuous_texels, class Component = float>
struct DiscKernel {
    using View = GatherInputsView<Component>;
    static constexpr bool continuous = continuous_texels;
    static constexpr int band = 32;  // rows that rotation_packets.h sorts together

    static int samples(const GatherUniforms& u) { return u.samples; }

    template <class F, class Point, class Row, class Tap>
    PLUMB_INLINE static void gather(const View& in, const Point& point, const Row& rotation, vec3<F>& sum, Tap& tap) {
        gather_samples<F, continuous>(in, point, rotation, sum, tap);
    }
    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return vec4<F>(gather_disc<F, continuous>(in, px, py, tap), F(0.0f));
    }
};

struct AllKernel {
    using View = AllInputsView;
    static constexpr int band = 1;  // a row takes long enough

    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return vec4<F>(gather_all<F>(in, px, py, tap), F(0.0f));
    }
    static float* out(const View& in) { return in.irradiance; }
};

}  // namespace plumb::rsm
