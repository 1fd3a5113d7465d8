// Irradiance of a pixel from that of elements (HEM 5.5: "per-vertex"): the algorithm that lookup.comp mirrors line by line.
//
//     H = H_0 + b (H_1 - H_0) + c (H_2 - H_0)
//
// A GPU's rasterizer interpolates vertices' colours as an attribute. Here barycentrics come from what a G-buffer holds, position and
// triangle: p = P_0 + b e1 + c e2 by least squares, b = ((d x e2) . n) / n^2, c = ((e1 x d) . n) / n^2, d = p - P_0, n = e1 x e2.
// P_0 is an end of the shortest edge where that is much shorter: along a sliver c is then as good as its corners are, whatever b
// across it is.
//
// differs: HEM interpolates radiosity, so that one material has one colour a vertex; irradiance times the pixel's own reflectance
// keeps textures sharp, and is the same where the reflectance is constant.
#pragma once

#include "core/number.h"
#include "raster/surface_kernel.h"

namespace plumb::radiosity {

// The twin's uniform block (std140).
struct LookupUniforms {
    std::int32_t width, height;
    std::int32_t triangles;
    std::int32_t elements;
};
static_assert(sizeof(LookupUniforms) == 16);

struct LookupView {
    LookupUniforms u;
    const float* position;           // [height][width][4]: xyz m
    const std::int32_t* id;          // [height][width][2]: object, triangle; -1, -1: nothing
    const float* corners;            // [triangles][3][4]: xyz m
    const std::int32_t* of;          // [triangles][4]: element at each corner
    const float* own;                // [elements][4]: xyz W/m2
    float* irradiance;               // out: [height][width][4]
};

template <class F>
PLUMB_INLINE F length2(const vec3<F>& v) {
    return dot3(v, v);
}

template <class F, class Tap>
PLUMB_INLINE vec4<F> lookup(const LookupView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using raster::cross3;
    using raster::minus3;
    using N = number<F>;
    using I = index_t<F>;
    const LookupUniforms& u = in.u;
    const I pixel = py * I(u.width) + px;
    const I triangle = N::fetch(in.id, pixel * I(2) + I(1));      tap("triangle", triangle, "-1: nothing is seen");
    const mask_t<F> has = in_range(triangle, I(u.triangles));
    const I t = select(has, triangle, I(0));
    vec3<F> corner[3];
    for (int k = 0; k < 3; ++k) corner[k] = xyz<F>(N::fetch4(in.corners, t * I(3) + I(k)));
    // The square of a length ratio that no regular mesh has: a device that rounds otherwise decides alike.
    const F across = length2(minus3(corner[2], corner[1])) * F(7.0f);
    const mask_t<F> next = (across < length2(minus3(corner[1], corner[0]))) & (across < length2(minus3(corner[0], corner[2])));
    tap("next", select(next, F(1.0f), F(0.0f)), "1: the edge of corners 1 and 2 is much the shortest; they are the first ones then");
    const auto first = [&](const vec3<F>(&of)[3], int k) { return select3<F>(next, of[(k + 1) % 3], of[k]); };
    const vec3<F> a = first(corner, 0), b = first(corner, 1), c = first(corner, 2), p = xyz<F>(N::fetch4(in.position, pixel));
    const vec3<F> e1 = minus3(b, a), e2 = minus3(c, a), d = minus3(p, a), n = cross3(e1, e2);
    const F area = dot3(n, n);                                    tap("area", area, "n^2: the triangle's area twice, squared, m4");
    const F scale = F(1.0f) / select(area > F(0.0f), area, F(1.0f));
    const F beta = max(F(0.0f), min(dot3(cross3(d, e2), n) * scale, F(1.0f)));
    const F gamma = max(F(0.0f), min(dot3(cross3(e1, d), n) * scale, F(1.0f) - beta));
    tap("beta", beta, "of the second corner, 0..1"), tap("gamma", gamma, "of the third, 0..1 - beta");
    vec3<F> h[3];
    mask_t<F> known = has;
    for (int k = 0; k < 3; ++k) {
        const I element = N::fetch(in.of, t * I(4) + I(k));
        known = known & in_range(element, I(u.elements));
        h[k] = xyz<F>(N::fetch4(in.own, select(in_range(element, I(u.elements)), element, I(0))));
        tap("corner", h[k], "irradiance of its element, W/m2");
    }
    const vec2<F> l{beta, gamma};
    const vec3<F> from = first(h, 0);
    const vec3<F> mixed = raster::interpolate3(from, minus3(first(h, 1), from), minus3(first(h, 2), from), l);
    const vec4<F> irradiance{select(known, mixed.x, F(0.0f)), select(known, mixed.y, F(0.0f)), select(known, mixed.z, F(0.0f)), F(0.0f)};
    tap("irradiance", xyz<F>(irradiance), "W/m2; 0 where nothing is seen");
    return irradiance;
}

struct LookupKernel {
    using View = LookupView;
    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return lookup<F>(in, px, py, tap);
    }
    static float* out(const View& in) { return in.irradiance; }
};

}  // namespace plumb::radiosity
