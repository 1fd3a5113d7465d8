// Light at vertices (HEM 5.3): the algorithm that vertices.comp mirrors line by line.
//
// Every vertex has light on either side of its surface: along its normal n, and along -n, for triangles that are seen from
// behind (raster/surface_kernel.h turns normals by the face). Items are the vertices' fronts, then their backs, in rows.
//
// differs: HEM culls what is seen from behind.
#pragma once

#include "gi/zbuffer/shade_kernel.h"

namespace plumb::zbuffer {

// The twin's uniform block (std140).
struct VerticesUniforms {
    ShadeUniforms shade;
    std::int32_t width, height;
    std::int32_t count;  // vertices
    std::int32_t padding;
};
static_assert(sizeof(VerticesUniforms) == 80);

struct VerticesView {
    VerticesUniforms u;
    const float* vertices;            // [count][2][4]: xyz m; xyz unit normal, or 0
    const std::int32_t* kinds;        // [count][2]: material, object
    const float* materials;           // [materials][2][4]: C_m; C_s, n
    const float* objects;             // [objects][6][4]: WorldRows
    const raster::LightArgs* lights;  // [lights]
    float* diffuse;                   // out: [height][width][4], W/m2; w 1
    float* specular;                  // out: the same
};

template <class F, class Tap>
PLUMB_INLINE Lit<F> vertex_light(const VerticesView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const VerticesUniforms& u = in.u;
    const I item = py * I(u.width) + px;
    const mask_t<F> front = item < I(u.count);
    const I vertex = max(I(0), min(select(front, item, item - I(u.count)), I(u.count - 1)));
    tap("vertex", vertex, "of those that are shaded");
    const I material = max(I(0), min(N::fetch(in.kinds, vertex * I(2)), I(u.shade.materials - 1)));
    const I object = max(I(0), min(N::fetch(in.kinds, vertex * I(2) + I(1)), I(u.shade.objects - 1)));
    const vec3<F> x = xyz<F>(N::fetch4(in.vertices, vertex * I(2)));  tap("x", x, "world, m");
    vec3<F> n = xyz<F>(N::fetch4(in.vertices, vertex * I(2) + I(1)));
    const WorldRows<F> world = fetch_world<F>(in.objects, object);
    if (u.shade.published != 0) n = turned(world.normal, n);
    const F side = select(front, F(1.0f), F(-1.0f));
    n = {n.x * side, n.y * side, n.z * side};                     tap("n", n, "normal, on that side");
    const vec3<F> v = unit_along(vec3<F>(F(u.shade.eye[0]) - x.x, F(u.shade.eye[1]) - x.y, F(u.shade.eye[2]) - x.z));
    tap("v", v, "towards the viewer, unit");
    const vec4<F> k = N::fetch4(in.materials, material * I(2) + I(1));
    tap("exponent", k.w, "n, of the material");
    const Lit<F> lit = lit_by<F>(u.shade, in.lights, x, n, v, k.w, world, tap);
    return coloured<F>(u.shade, lit, xyz<F>(N::fetch4(in.materials, material * I(2))), xyz<F>(k), tap);
}

struct VerticesKernel {
    using View = VerticesView;
    template <class F, class Tap>
    PLUMB_INLINE static Lit<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return vertex_light<F>(in, px, py, tap);
    }
    template <class F>
    static void store(const View& in, index_t<F> at, const Lit<F>& lit, mask_t<F> active) {
        number<F>::store4(in.diffuse, at, vec4<F>(lit.diffuse, F(1.0f)), active);
        number<F>::store4(in.specular, at, vec4<F>(lit.specular, F(1.0f)), active);
    }
    // The last row may be longer than the list.
    template <class F>
    PLUMB_INLINE static mask_t<F> writes(const View& in, index_t<F> px, index_t<F> py) {
        using I = index_t<F>;
        return py * I(in.u.width) + px < I(2 * in.u.count);
    }
};

}  // namespace plumb::zbuffer
