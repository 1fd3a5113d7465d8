// Light at pixels (HEM 5.4): the algorithm that pixels.comp mirrors line by line.
//
// The normal is the G-buffer's: interpolated, of unit length, bent by a normal map, on the side that is seen. As printed it is
// interpolated from what the vertex shader makes of the vertices' normals, and so is the direction to the viewer, from unit vectors.
// Left as it is interpolated it is shorter than 1 (figure 5.2).
#pragma once

#include "gi/zbuffer/interpolate_kernel.h"
#include "gi/zbuffer/shade_kernel.h"

namespace plumb::zbuffer {

// Which normal a pixel is lit by.
enum class PixelNormal : int { of_gbuffer, renormalised, interpolated };

// The twin's uniform block (std140).
struct PixelsUniforms {
    ShadeUniforms shade;
    std::int32_t width, height;
    std::int32_t triangles;  // that `id` counts
    std::int32_t vertices;
    std::int32_t normal;     // PixelNormal
    std::int32_t emits;      // 1: emission is shown
    std::int32_t padding[2];
};
static_assert(sizeof(PixelsUniforms) == 96);

struct PixelsView {
    PixelsUniforms u;
    const float* position;            // [height][width][4]: xyz m
    const float* normal;              // [height][width][4]: xyz unit
    const float* albedo;              // [height][width][4]: C_m
    const float* emission;            // [height][width][4]: M, W/m2
    const std::int32_t* id;           // [height][width][2]: object, triangle; -1, -1: nothing
    const std::int32_t* corners;      // [triangles][4]: vertices A, B, C; 0
    const float* vertices;            // [vertices][2][4]: xyz m; xyz normal
    const std::int32_t* kinds;        // [vertices][2]: material, object
    const float* materials;           // [materials][2][4]: C_m; C_s, n
    const float* objects;             // [objects][6][4]: WorldRows
    const raster::LightArgs* lights;  // [lights]
    float* irradiance;                // out: as InterpolateView has it
    float* sent;                      // out
};

// Unit vectors from the corners to the viewer, interpolated and made unit again, as PS_CAS does.
template <class F>
PLUMB_INLINE vec3<F> printed_view(const PixelsView& in, const SeenTriangle<F>& s) {
    using I = index_t<F>;
    const float* eye = in.u.shade.eye;
    const auto from = [&](const vec3<F>& p) {
        return unit_along(vec3<F>(F(eye[0]) - p.x, F(eye[1]) - p.y, F(eye[2]) - p.z));
    };
    const vec3<F> a = from(s.p_a), b = from(xyz<F>(number<F>::fetch4(in.vertices, s.b * I(2)))),
                  c = from(xyz<F>(number<F>::fetch4(in.vertices, s.c * I(2))));
    return raster::normalised(raster::interpolate3(a, raster::minus3(b, a), raster::minus3(c, a), s.l));
}

template <class F, class Tap>
PLUMB_INLINE Sent<F> pixel_light(const PixelsView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const PixelsUniforms& u = in.u;
    const I pixel = py * I(u.width) + px;
    const vec3<F> x = xyz<F>(N::fetch4(in.position, pixel));      tap("x", x, "world, m");
    const SeenTriangle<F> s = seen_triangle<F>(in, pixel, x, u.shade.eye, u.triangles, u.vertices, tap);
    const I material = max(I(0), min(N::fetch(in.kinds, s.a * I(2)), I(u.shade.materials - 1)));
    const I object = max(I(0), min(N::fetch(in.kinds, s.a * I(2) + I(1)), I(u.shade.objects - 1)));
    const WorldRows<F> world = fetch_world<F>(in.objects, object);

    vec3<F> n = xyz<F>(N::fetch4(in.normal, pixel));
    vec3<F> v = unit_along(vec3<F>(F(u.shade.eye[0]) - x.x, F(u.shade.eye[1]) - x.y, F(u.shade.eye[2]) - x.z));
    if (u.normal != int(PixelNormal::of_gbuffer)) {
        vec3<F> between = s.normal;
        if (u.shade.published != 0) {
            const vec3<F> a = turned(world.normal, s.n_a), b = turned(world.normal, s.n_b), c = turned(world.normal, s.n_c);
            between = raster::interpolate3(a, raster::minus3(b, a), raster::minus3(c, a), s.l);
            v = printed_view<F>(in, s);
        }
        const vec3<F> unit = raster::normalised(between);
        const vec3<F> taken = u.normal == int(PixelNormal::renormalised) ? unit : between;
        n = {taken.x * s.side, taken.y * s.side, taken.z * s.side};
    }
    tap("n", n, "normal");
    tap("v", v, "towards the viewer, unit");
    const vec4<F> k = N::fetch4(in.materials, material * I(2) + I(1));
    tap("exponent", k.w, "n, of the material");
    const Lit<F> lit = lit_by<F>(u.shade, in.lights, x, n, v, k.w, world, tap);
    const vec3<F> rho = xyz<F>(N::fetch4(in.albedo, pixel));
    const Lit<F> of = coloured<F>(u.shade, lit, rho, xyz<F>(k), tap);
    const vec3<F> dark{F(0.0f), F(0.0f), F(0.0f)}, m = xyz<F>(N::fetch4(in.emission, pixel));
    const F emits(float(u.emits));
    const vec3<F> all{emits * m.x + of.specular.x, emits * m.y + of.specular.y, emits * m.z + of.specular.z};
    const vec3<F> irradiance = select3<F>(s.seen, of.diffuse, dark), sent = select3<F>(s.seen, all, dark);
    tap("irradiance", irradiance, "diffuse, W/m2");
    tap("sent", sent, "M + C_s ..., W/m2");
    return {vec4<F>(irradiance, F(0.0f)), vec4<F>(sent, F(0.0f))};
}

struct PixelsKernel {
    using View = PixelsView;
    template <class F, class Tap>
    PLUMB_INLINE static Sent<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return pixel_light<F>(in, px, py, tap);
    }
    template <class F>
    static void store(const View& in, index_t<F> at, const Sent<F>& s, mask_t<F> active) {
        number<F>::store4(in.irradiance, at, s.irradiance, active);
        number<F>::store4(in.sent, at, s.sent, active);
    }
};

}  // namespace plumb::zbuffer
