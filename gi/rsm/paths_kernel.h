// The gather along paths with a micro linear buffer for visibility (VRSM 3.2, 3.3): the algorithm that gather_paths.glsl
// mirrors line by line.
//
// Whatever hides texel p from x lies, seen from the light, on the straight line from x to p. So samples are taken along
// straight paths that start at the projection of x, from near to far, and each path keeps which elevations, as the light
// sees them, it has met: a sample whose elevation is taken is hidden.
//
//         ^ elevation
//     slot 4 |      o            the light looks down; the horizontal axis is a path on the map
//     slot 3 |          o    o   <- hidden: slot 3 is taken
//     slot 2 x----+-------------
//     slot 1 |  o                <- visible, and takes slot 1
//     slot 0 |
//
// A point beside the map whose projection is held at its border (`projection = "clamped"`, ours) has no such lines: its
// paths start elsewhere, and nothing is hidden from it. Towards the border what is hidden fades, so that no line is seen there.
//
// differs: the elevation phi of a sample is never computed. Slot i ends where sin(phi) = s_i, and with d = x_p - x and
// dz = d . axis, sin(phi) = dz / |d|: the test is dz |dz| >= s_i |s_i| |d|^2. A texel without a surface neither hides nor
// sends light; the thesis does not say what it does.
//
// differs: with a thickness (ours) a sample takes the slots below its own, too, down to that of the point so far below it,
// or as far below as it is above the plane of x: the light sees the top of a wall alone.
#pragma once

#include "gi/rsm/gather_kernel.h"

namespace plumb::rsm {

// The twin's uniform block (std140).
struct PathsUniforms {
    raster::Projection map;
    float axis[4];            // xyz: unit, from the scene towards the light along the view's axis
    float least_distance2;    // m2: the floor of |x - x_p|^2
    float scale;              // 1/pi; published: 1
    std::int32_t directions;  // paths
    std::int32_t steps;       // samples of a path
    std::int32_t rotations;   // a power of two
    std::int32_t tile;        // as GatherUniforms'
    std::int32_t width;       // of the image of shading points
    std::int32_t height;
    std::uint32_t seed;
    std::int32_t reach;       // texels: the pattern's largest |dx| or |dy|
    std::int32_t slots;       // of the micro linear buffer, 2 to 32; 0: without visibility
    std::int32_t propagates;  // -1: Algorithms 3 and 6, 0: Algorithm 2
    float texel_area[4];      // as GatherUniforms'
    float sample_area;
    float fade;               // 1/texels from a clamped map's border to where samples hide all they hide; 1e30: at once
    float thickness;          // m: how far below a sample its surface reaches; 0: a sample takes its own slot alone
    std::int32_t padding[1];
};
static_assert(sizeof(PathsUniforms) == 160);

// One invocation's inputs. Component is float or Half: the storage of the map's records.
template <class Component>
struct PathsInputsView {
    PathsUniforms u;
    const float* position;        // [height][width] rgba32f: xyz world, m
    const float* normal;          // [height][width] rgba32f: xyz unit
    const float* rsm_position;    // [size][size] rgba32f: xyz world, m
    const float* rsm_normal;      // [size][size] rgba32f: xyz unit; w: 1 where there is a surface
    const float* rsm_flux;        // [size][size] rgba32f: xyz W
    const Component* records;     // [size][size] records: the three of them
    const std::int32_t* offsets;  // [directions][steps][rotations]: whole texels, dx in the lower 16 bits, dy in the upper
    const float* positions;       // continuous: [directions][steps][rotations][2]: dx, dy in texels
    const float* weights;         // [directions][steps][rotations]: texels that a sample stands for
    const float* edges;           // [slots - 1]: s |s| where slots meet, s the sine of the elevation; ascending
    float* irradiance;            // [height][width] rgba32f, out: W/m2
};

// What a path has met: bit i of `free` is 1 while no sample was in slot i. `last` is the bit of the sample before, where
// visibility propagates from it.
template <class F>
struct MicroLinearBuffer {
    index_t<F> free, last, last_visible;
};

// Bits: the slots below a sample's own down to that of the lower end of its surface.
template <class F, class Component, class Tap>
PLUMB_INLINE index_t<F> slots_below(const PathsInputsView<Component>& in, const vec3<F>& d, const vec3<F>& n, const F& dz,
                                    const index_t<F>& slot, Tap& tap) {
    using I = index_t<F>;
    // Behind the plane of x it is below 0: the end then lies above the sample, and no slot between.
    const F depth = min(F(in.u.thickness), dot3(n, d));
    tap("depth", depth, "m: how far below x_p its surface reaches; what is so short does not cross the plane of x");
    const vec3<F> low = d - vec3<F>{F(in.u.axis[0]), F(in.u.axis[1]), F(in.u.axis[2])} * depth;
    const F low_dz = dz - depth;
    tap("low_dz", low_dz, "height of the lower end above x towards the light, m");
    const F low_height = low_dz * abs(low_dz), low_d2 = dot3(low, low);
    I below(0);
    for (int i = 0; i + 1 < in.u.slots; ++i) {
        const mask_t<F> covered = (I(i) < slot) & (low_height < F(in.edges[i]) * low_d2);
        below = select(covered, below | I(std::int32_t(1u << i)), below);
    }
    tap("below", below, "bits of the slots below the sample's own that it hides");
    return below;
}

// The visibility of a sample, 0 or 1. The counter of Algorithm 6, clamped to 0..1, is the flag of Algorithm 3: 1 until a
// sample takes the slot, then 0, -1, ... which are 0. Algorithm 2 is the same without the sample before.
template <class F, class Component, class Tap>
PLUMB_INLINE F visibility_of(const PathsInputsView<Component>& in, const vec3<F>& d, const vec3<F>& n, const mask_t<F>& surface,
                             MicroLinearBuffer<F>& met, Tap& tap) {
    using I = index_t<F>;
    const F dz = dot3(vec3<F>{F(in.u.axis[0]), F(in.u.axis[1]), F(in.u.axis[2])}, d);
    tap("dz", dz, "height of x_p above x towards the light, m");
    const F height = dz * abs(dz), d2 = dot3(d, d);
    I slot(0), bit(1);
    for (int i = 0; i + 1 < in.u.slots; ++i) {
        const mask_t<F> above = height >= F(in.edges[i]) * d2;
        slot = select(above, I(i + 1), slot);
        bit = select(above, I(std::int32_t(2u << i)), bit);
    }
    tap("slot", slot, "VRSM Algorithm 3, line 2: idx");

    // Where there is no surface nothing is met: the sample repeats the one before.
    bit = select(surface, bit, met.last);
    const I visible = select(bit == met.last, met.last_visible, met.free & bit);
    met.free = met.free & ~bit;
    if (in.u.thickness > 0.0f) {
        const I below = slots_below<F>(in, d, n, dz, slot, tap);
        met.free = select(surface, met.free & ~below, met.free);
    }
    met.last = bit & I(in.u.propagates);
    met.last_visible = visible;
    return select(visible == I(0), F(0.0f), F(1.0f));
}

// What the paths of a pixel share.
template <class F, bool continuous>
struct PathsPoint : ProjectedPoint<F, continuous> {
    F sight;  // 1 where paths are lines of sight, 0 where they do not start where x lies
};

template <class F, bool continuous, class Component, class Tap>
PLUMB_INLINE PathsPoint<F, continuous> projected_point(const PathsInputsView<Component>& in, const index_t<F>& px,
                                                     const index_t<F>& py, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const PathsUniforms& u = in.u;
    const I pixel = py * I(u.width) + px;
    const vec3<F> x = xyz<F>(N::fetch4(in.position, pixel));      tap("x", x, "world, m");
    const vec3<F> n = xyz<F>(N::fetch4(in.normal, pixel));        tap("n", n, "unit normal of x");
    const TexelsOf<F, continuous> texels(u.map, x, tap);
    const I rotation = rotation_of(u, px, py);
    tap("rotation", rotation, "column of the tables of offsets and weights");
    F sight(1.0f);
    if (u.map.low >= 0.0f) sight = clamp(texels.within(u.map) * F(u.fade), F(0.0f), F(1.0f));
    tap("sight", sight, "0 where the projection is held on the map: nothing hides a sample there");
    return {{x, n, texels, rotation, texels.near(u.map.size, u.reach)}, sight};
}

// Adds a path's samples to the sum. `rotation` is the point's own or what rotation_packets.h knows of it.
template <class F, bool continuous, class Component, class Row, class Tap>
PLUMB_INLINE void gather_path(const PathsInputsView<Component>& in, const PathsPoint<F, continuous>& point,
                              const Row& rotation, int path, vec3<F>& sum, Tap& tap) {
    using I = index_t<F>;
    const PathsUniforms& u = in.u;
    MicroLinearBuffer<F> met{I(-1), I(0), I(0)};
    for (int step = 0; step < u.steps; ++step) {
        const int k = path * u.steps + step;
        if (adds_nothing(rotation, k)) continue;
        tap.sample(k);
        const MapSample<F> sample = map_sample<F>(in, point, rotation, k, tap);
        tap("texel", sample.texel, "VRSM Algorithm 5, line 8: proj + (u, v)");
        tap("inside", sample.inside, "1 if the map has that texel; if not, what follows is texel 0 with weight 0");
        const vec3<F> x_p = xyz<F>(sample.p.a), n_p = xyz<F>(sample.p.b), flux = xyz<F>(sample.p.c);
        const F of_table = entry<F>(in.weights, row_of(rotation, k * u.rotations));
        const F weight = select(sample.inside, of_table, F(0.0f));
        tap("x_p", x_p, "world, m");
        tap("n_p", n_p, "unit normal of x_p");
        tap("flux", flux, "Phi_p, W");
        tap("weight", weight, "texels: (2 pi rho / M) (r / K); published: rho^2, normalised");

        F visibility(1.0f);
        const mask_t<F> surface = sample.inside & (sample.p.b.w > F(0.0f));
        if (u.slots > 0) visibility = visibility_of<F>(in, x_p - point.x, point.n, surface, met, tap);
        visibility = max(visibility, F(1.0f) - point.sight);
        tap("visibility", visibility, "VRSM Algorithm 5, line 12: 1 visible, 0 hidden; 1 - sight at least");

        F share(1.0f);
        if (u.sample_area > 0.0f) share = share_of_disc(u, point.x, x_p, n_p, weight, tap);
        const F g = form(point.x, point.n, x_p, n_p, F(u.least_distance2), tap) * (weight * visibility * share);
        sum.x += flux.x * g;
        sum.y += flux.y * g;
        sum.z += flux.z * g;
        tap("sum", sum, "VRSM Algorithm 5, line 15: sum so far of v w Phi_p form, W/m2");
    }
}

template <class F, bool continuous, class Tap>
PLUMB_INLINE vec3<F> irradiance_of(const PathsUniforms& u, const PathsPoint<F, continuous>& point, const vec3<F>& sum,
                                   Tap& tap) {
    tap.sample(-1);
    const vec3<F> zero{F(0.0f), F(0.0f), F(0.0f)};
    const vec3<F> irradiance = select3<F>(point.near, sum * F(u.scale), zero);
    tap("irradiance", irradiance, "E = sum / pi, W/m2");
    return irradiance;
}

// The whole of a pixel. rotation_packets.h puts the same parts together.
template <class F, bool continuous = false, class Component, class Tap>
PLUMB_INLINE vec3<F> gather_paths(const PathsInputsView<Component>& in, index_t<F> px, index_t<F> py, Tap& tap) {
    const auto point = projected_point<F, continuous>(in, px, py, tap);
    vec3<F> sum{F(0.0f), F(0.0f), F(0.0f)};
    for (int path = 0; any(point.near) && path < in.u.directions; ++path)
        gather_path<F, continuous>(in, point, point.rotation, path, sum, tap);
    return irradiance_of<F, continuous>(in.u, point, sum, tap);
}

// Rows are shaded in an order of their own: rotation_packets.h.
template <bool continuous_texels, class Component = float>
struct PathsKernel {
    using View = PathsInputsView<Component>;
    static constexpr bool continuous = continuous_texels;

    static constexpr int band = 32;  // rows that rotation_packets.h sorts together

    static int samples(const PathsUniforms& u) { return u.directions * u.steps; }

    template <class F, class Point, class Row, class Tap>
    PLUMB_INLINE static void gather(const View& in, const Point& point, const Row& rotation, vec3<F>& sum, Tap& tap) {
        for (int path = 0; path < in.u.directions; ++path)
            gather_path<F, continuous>(in, point, rotation, path, sum, tap);
    }
    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return vec4<F>(gather_paths<F, continuous>(in, px, py, tap), F(0.0f));
    }
};

}  // namespace plumb::rsm
