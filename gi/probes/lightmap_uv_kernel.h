// Where on the lightmap a pixel's surface lies: the algorithm that lightmap_uv.comp mirrors line by line.
//
// A GPU's rasterizer interpolates the lightmap's coordinates as an attribute (IPR 3.3.1.4). Here they come from what a G-buffer
// holds, position and triangle (raster/barycentric_kernel.h): p = A + b e1 + c e2, e1 = B - A, e2 = C - A; which holds for positions
// that a target has rounded, too.
//
// Beside it the pixel's level of detail, by its distance (IPR 4.2.4): whole levels, and the share of the next coarser one.
#pragma once

#include "gi/probes/level_kernel.h"
#include "raster/barycentric_kernel.h"

namespace plumb::probes {

// The twin's uniform block (std140).
struct LightmapUvUniforms {
    std::int32_t width, height;
    std::int32_t triangles;  // that `id` counts: of the frame
    std::int32_t charted;    // that have a place on the lightmap: static ones
    std::int32_t levels;     // of detail; 1: none
    std::int32_t padding[3];
    float eye[4];            // xyz m
    float forward[4];        // xyz unit
    float zones[4];          // cosine, sine of the front's half angle; of the side's
    float scales[4];         // xyz: of distances in front, at the side, behind
    float distances[4];      // xyz m: where levels 1, 2, 3 begin
    float widths[4];         // xyz m: over which a pixel changes to them
};
static_assert(sizeof(LightmapUvUniforms) == 128);

struct LightmapUvView {
    LightmapUvUniforms u;
    const float* position;               // [height][width][4]: xyz m
    const std::int32_t* id;              // [height][width][2]: object, triangle; -1, -1: nothing
    const std::int32_t* charted_of;      // [triangles]: index into `corners`, -1: none
    const float* corners;                // [charted][4][4]: xyz of A, B, C in m, w their u; then their v, and 0
    float* uv;                           // out: [height][width][4]
};

template <class F, class Tap>
PLUMB_INLINE vec4<F> lightmap_uv(const LightmapUvView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const LightmapUvUniforms& u = in.u;
    const I pixel = py * I(u.width) + px;
    const I triangle = N::fetch(in.id, pixel * I(2) + I(1));
    const I charted = N::fetch(in.charted_of, max(I(0), min(triangle, I(u.triangles - 1))));
    const mask_t<F> has = in_range(triangle, I(u.triangles)) & in_range(charted, I(u.charted));
    tap("triangle", triangle, "of the frame; -1: nothing is seen"), tap("charted", charted, "of the lightmap; -1: none");
    const I first = max(I(0), min(charted, I(u.charted - 1))) * I(4);
    const vec4<F> a = N::fetch4(in.corners, first), b = N::fetch4(in.corners, first + I(1)), c = N::fetch4(in.corners, first + I(2)),
                  v = N::fetch4(in.corners, first + I(3)), p = N::fetch4(in.position, pixel);
    const vec3<F> e1{b.x - a.x, b.y - a.y, b.z - a.z}, e2{c.x - a.x, c.y - a.y, c.z - a.z}, d{p.x - a.x, p.y - a.y, p.z - a.z};
    const raster::Barycentrics<F> at = raster::barycentrics_of(d, e1, e2);
    tap("area", at.area, "n^2: the triangle's area twice, squared, m4");
    const F beta = at.l.x, gamma = at.l.y;
    tap("beta", beta, "of B, 0..1"), tap("gamma", gamma, "of C, 0..1 - beta");
    const F x = a.w + beta * (b.w - a.w) + gamma * (c.w - a.w), y = v.x + beta * (v.y - v.x) + gamma * (v.z - v.x);
    const F distance = point_distance<F>(xyz<F>(p), u.eye, u.forward, u.zones, u.scales);
    tap("distance", distance, "from the eye, scaled by zones, m");
    const I level = level_of<F>({distance, distance, distance}, u.distances, u.levels);
    const F share = blend_of<F>(distance, level, u.distances, u.widths, u.levels);
    tap("level", level, "of detail"), tap("share", share, "of the next coarser level");
    const vec4<F> uv{select(has, x, F(-1.0f)), select(has, y, F(-1.0f)), select(has, N::from_index(level) + share, F(0.0f)),
                     select(has, F(1.0f), F(0.0f))};
    tap("uv", xyz<F>(uv), "on the lightmap, level of detail; -1, -1: it has no place there");
    return uv;
}

struct LightmapUvKernel {
    using View = LightmapUvView;
    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return lightmap_uv<F>(in, px, py, tap);
    }
    static float* out(const View& in) { return in.uv; }
};

}  // namespace plumb::probes
