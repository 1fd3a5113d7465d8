// Gouraud's interpolation (HEM 5.3): what a pixel sees of the light at its triangle's vertices; interpolate.comp mirrors it line by
// line.
//
//     E(p) = E_A + b (E_B - E_A) + c (E_C - E_A)
//
// with b and c of raster/barycentric_kernel.h, and the light of the side that is seen.
#pragma once

#include "core/number.h"
#include "raster/barycentric_kernel.h"

namespace plumb::zbuffer {

// The twin's uniform block (std140).
struct InterpolateUniforms {
    std::int32_t width, height;
    std::int32_t triangles;  // that `id` counts
    std::int32_t vertices;
    std::int32_t row;        // items a row of the vertices' light
    std::int32_t emits;      // 1: emission is shown
    std::int32_t padding[2];
    float eye[4];            // xyz m
};
static_assert(sizeof(InterpolateUniforms) == 48);

struct InterpolateView {
    InterpolateUniforms u;
    const float* position;       // [height][width][4]: xyz m
    const std::int32_t* id;      // [height][width][2]: object, triangle; -1, -1: nothing
    const float* emission;       // [height][width][4]: M, W/m2
    const std::int32_t* corners; // [triangles][4]: vertices A, B, C; 0
    const float* vertices;       // [vertices][2][4]: xyz m; xyz normal
    const float* diffuse;        // [2 vertices][4]: fronts, backs, W/m2
    const float* specular;       // the same
    float* irradiance;           // out: [height][width][4]: W/m2
    float* sent;                 // out: [height][width][4]: what is sent beside diffuse reflection, M and pi times highlights, W/m2
};

template <class F>
struct Sent {
    vec4<F> irradiance, sent;
    template <class Each>
    void components(Each each) const {
        for (const vec4<F>& v : {irradiance, sent}) each(v.x), each(v.y), each(v.z), each(v.w);
    }
};

// A point that lies so many edges away from a corner is none of the triangle's, wherever a target has rounded it to: A stands in.
inline constexpr float farthest = 1024;

// The corners of the triangle that a pixel sees; of the first where it sees none.
template <class F>
struct SeenTriangle {
    mask_t<F> seen;
    index_t<F> a, b, c;          // vertices
    vec3<F> p_a, n_a, n_b, n_c;  // position of A; normals
    vec2<F> l;                   // barycentrics of B and C
    vec3<F> normal;              // interpolated, of any length
    F side;                      // +1, or -1: what is seen is the back of its normals
};
template <class F, class View, class Tap>
PLUMB_INLINE SeenTriangle<F> seen_triangle(const View& in, index_t<F> pixel, const vec3<F>& p, const float* eye,
                                           std::int32_t triangles, std::int32_t vertices, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    SeenTriangle<F> s;
    const I triangle = N::fetch(in.id, pixel * I(2) + I(1));      tap("triangle", triangle, "of the frame; -1: nothing is seen");
    s.seen = in_range(triangle, I(triangles));
    const I first = max(I(0), min(triangle, I(triangles - 1))) * I(4);
    const auto corner = [&](int k) { return max(I(0), min(N::fetch(in.corners, first + I(k)), I(vertices - 1))); };
    s.a = corner(0), s.b = corner(1), s.c = corner(2);
    s.p_a = xyz<F>(N::fetch4(in.vertices, s.a * I(2)));
    const vec3<F> e1 = raster::minus3(xyz<F>(N::fetch4(in.vertices, s.b * I(2))), s.p_a);
    const vec3<F> e2 = raster::minus3(xyz<F>(N::fetch4(in.vertices, s.c * I(2))), s.p_a);
    s.n_a = xyz<F>(N::fetch4(in.vertices, s.a * I(2) + I(1)));
    s.n_b = xyz<F>(N::fetch4(in.vertices, s.b * I(2) + I(1)));
    s.n_c = xyz<F>(N::fetch4(in.vertices, s.c * I(2) + I(1)));
    // Scaled first, so that no product overflows.
    const F scale = F(1.0f) / max(max(raster::largest3(e1), raster::largest3(e2)), F(1e-37f));
    const vec3<F> edge1{e1.x * scale, e1.y * scale, e1.z * scale}, edge2{e2.x * scale, e2.y * scale, e2.z * scale};
    const vec3<F> from_a = raster::minus3(p, s.p_a);
    vec3<F> d{from_a.x * scale, from_a.y * scale, from_a.z * scale};
    const mask_t<F> near = raster::largest3(d) <= F(farthest);
    d = select3<F>(near, d, vec3<F>(F(0.0f), F(0.0f), F(0.0f)));
    s.l = raster::barycentrics_of<F>(d, edge1, edge2).l;
    tap("barycentrics", s.l, "b, c: of B and of C");
    s.normal = raster::interpolate3(s.n_a, raster::minus3(s.n_b, s.n_a), raster::minus3(s.n_c, s.n_a), s.l);
    const vec3<F> face = raster::cross3(edge1, edge2);
    const vec3<F> to_viewer{F(eye[0]) - s.p_a.x, F(eye[1]) - s.p_a.y, F(eye[2]) - s.p_a.z};
    const mask_t<F> given = dot3(s.normal, s.normal) > F(0.0f);
    s.side = raster::viewed_side(face, select3<F>(given, s.normal, face), to_viewer);
    tap("side", s.side, "1: the vertices' normals point to the viewer's side; -1: away");
    return s;
}

template <class F, class Tap>
PLUMB_INLINE Sent<F> interpolated(const InterpolateView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const InterpolateUniforms& u = in.u;
    const I pixel = py * I(u.width) + px;
    const vec3<F> p = xyz<F>(N::fetch4(in.position, pixel));
    const SeenTriangle<F> s = seen_triangle<F>(in, pixel, p, u.eye, u.triangles, u.vertices, tap);
    const I back = select(s.side < F(0.0f), I(u.vertices), I(0));
    const auto light = [&](const float* of) {
        const vec3<F> a = xyz<F>(N::fetch4(of, s.a + back)), b = xyz<F>(N::fetch4(of, s.b + back)),
                      c = xyz<F>(N::fetch4(of, s.c + back));
        return raster::interpolate3(a, raster::minus3(b, a), raster::minus3(c, a), s.l);
    };
    const vec3<F> dark{F(0.0f), F(0.0f), F(0.0f)};
    const vec3<F> irradiance = select3<F>(s.seen, light(in.diffuse), dark);
    tap("irradiance", irradiance, "of the vertices, W/m2");
    const vec3<F> highlight = light(in.specular), m = xyz<F>(N::fetch4(in.emission, pixel));
    tap("highlight", highlight, "of the vertices, W/m2");
    const F emits(float(u.emits));
    const vec3<F> all{emits * m.x + highlight.x, emits * m.y + highlight.y, emits * m.z + highlight.z};
    const vec3<F> sent = select3<F>(s.seen, all, dark);           tap("sent", sent, "M + C_s ..., W/m2");
    return {vec4<F>(irradiance, F(0.0f)), vec4<F>(sent, F(0.0f))};
}

struct InterpolateKernel {
    using View = InterpolateView;
    template <class F, class Tap>
    PLUMB_INLINE static Sent<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return interpolated<F>(in, px, py, tap);
    }
    template <class F>
    static void store(const View& in, index_t<F> at, const Sent<F>& s, mask_t<F> active) {
        number<F>::store4(in.irradiance, at, s.irradiance, active);
        number<F>::store4(in.sent, at, s.sent, active);
    }
};

}  // namespace plumb::zbuffer
