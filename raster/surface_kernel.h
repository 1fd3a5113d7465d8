// A point of a triangle: position, normal and material, interpolated by barycentric coordinates; surface.glsl is the
// twin, line by line. Shared by gbuffer_kernel.h and rsm_kernel.h.
#pragma once

#include "core/number.h"

namespace plumb::raster {

// What the kernels read of geometry and surfaces (raster/surfaces.h).
struct SurfaceArgs {
    const float* vertices;                 // [vertex][8]: position m, u, normal, v
    const std::int32_t* triangles;         // [triangle][3]
    const std::int32_t* material;          // [triangle]
    const float* materials;                // [material][16]: reflectance, 0, emission W/m2, 0, padding
    const std::int32_t* material_texture;  // [material]; 0 is the white texel
    const std::int32_t* textures;          // [texture][4]: first texel, width, height, 1 nearest | 2 sRGB
    const std::int32_t* texels;            // RGBA8
    const float* decode;                   // [2][256]
    float viewer[4];                       // xyz m, w 1: where the viewer is; w 0: the direction towards it
};

template <class F>
struct Surface {
    vec3<F> position;  // m
    vec3<F> normal;    // unit, on the side of the triangle that the viewer sees
    vec3<F> albedo;
    vec3<F> emission;  // W/m2
};

template <class F>
PLUMB_INLINE vec3<F> minus3(const vec3<F>& a, const vec3<F>& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}

template <class F>
PLUMB_INLINE F largest3(const vec3<F>& v) {
    return max(abs(v.x), max(abs(v.y), abs(v.z)));
}

// a + l1 (b - a) + l2 (c - a), from edges e1 = b - a, e2 = c - a: exact where a, b and c agree.
template <class F>
PLUMB_INLINE F interpolate(F a, F e1, F e2, const vec2<F>& l) {
    return a + (e1 * l.x + e2 * l.y);
}
template <class F>
PLUMB_INLINE vec3<F> interpolate3(const vec3<F>& a, const vec3<F>& e1, const vec3<F>& e2, const vec2<F>& l) {
    return {interpolate(a.x, e1.x, e2.x, l), interpolate(a.y, e1.y, e2.y, l), interpolate(a.z, e1.z, e2.z, l)};
}

// The triangle's own normal, of any length up to 2: edges are scaled first, so that no product of theirs vanishes.
template <class F>
PLUMB_INLINE vec3<F> face_normal(const vec3<F>& e1, const vec3<F>& e2) {
    const F scale = F(1.0f) / max(max(largest3(e1), largest3(e2)), F(1e-37f));
    const vec3<F> a{e1.x * scale, e1.y * scale, e1.z * scale}, b{e2.x * scale, e2.y * scale, e2.z * scale};
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// -1 where negative, else 1.
template <class F>
PLUMB_INLINE F side_of(F x) {
    return select(x < F(0.0f), F(-1.0f), F(1.0f));
}

// Unit normal: the interpolated one, or the face's where vertices have none, on the side of the face that is towards
// `to_viewer`. Turning by the face and not by the normal itself keeps shading smooth where a curved surface bends away.
template <class F>
PLUMB_INLINE vec3<F> viewed_normal(const vec3<F>& interpolated, const vec3<F>& face, const vec3<F>& to_viewer) {
    const mask_t<F> given = dot3(interpolated, interpolated) > F(0.0f);
    const vec3<F> n = select3<F>(given, interpolated, face);
    const F length = max(sqrt(dot3(n, n)), F(1e-30f));
    const F side = side_of(dot3(face, to_viewer)) * side_of(dot3(face, n));
    return {n.x / length * side, n.y / length * side, n.z / length * side};
}

// Brings an index that is off by less than one period into [0, size).
template <class F>
PLUMB_INLINE index_t<F> repeat(index_t<F> i, index_t<F> size) {
    using I = index_t<F>;
    const I up = select(i < I(0), i + size, i);
    return select(up >= size, up - size, up);
}

template <class F>
PLUMB_INLINE vec3<F> fetch_texel(const SurfaceArgs& in, index_t<F> at, index_t<F> curve) {
    using N = number<F>;
    using I = index_t<F>;
    const I texel = N::fetch(in.texels, at);
    auto channel = [&](int shift) { return N::fetch(in.decode, curve + (shift_right(texel, shift) & I(255))); };
    return {channel(0), channel(8), channel(16)};
}

// One lookup at level 0: repeat, then bilinear with weights in fp32, along u first, or nearest (weight 0).
template <class F, class Tap>
PLUMB_INLINE vec3<F> sample_texture(const SurfaceArgs& in, index_t<F> texture, const vec2<F>& uv, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const I row = texture * I(4);
    const I first = N::fetch(in.textures, row), width = N::fetch(in.textures, row + I(1));
    const I height = N::fetch(in.textures, row + I(2)), flags = N::fetch(in.textures, row + I(3));
    const I curve = (flags & I(2)) << 7;
    const mask_t<F> nearest = (flags & I(1)) > I(0);

    // Texel coordinates within one period; texel centres lie at whole numbers when filtering.
    auto coordinate = [&](F u, I size) {
        const F texels = (u - floor(u)) * N::from_index(size);
        return select(nearest, floor(texels), texels - F(0.5f));
    };
    const F x = coordinate(uv.x, width), y = coordinate(uv.y, height);
    const F left = floor(x), top = floor(y);
    const F along_u = x - left, along_v = y - top;

    // The clamp keeps the reads inside the image for coordinates that are no numbers.
    auto index_of = [&](F i, I size) { return repeat<F>(min(max(N::truncate_to_index(i), I(-1)), size), size); };
    const I x0 = index_of(left, width), y0 = index_of(top, height);
    const I x1 = repeat<F>(x0 + I(1), width), y1 = repeat<F>(y0 + I(1), height);
    tap("texel", ivec2<I>{x0, y0}, "upper left of the texels that are read");
    tap("texel_weight", vec2<F>{along_u, along_v}, "of the right and the lower texels");

    auto read = [&](I column, I line) { return fetch_texel<F>(in, first + line * width + column, curve); };
    const vec3<F> a = read(x0, y0), b = read(x1, y0), c = read(x0, y1), d = read(x1, y1);
    auto filter = [&](F a, F b, F c, F d) {
        const F upper = a + along_u * (b - a), lower = c + along_u * (d - c);
        return upper + along_v * (lower - upper);
    };
    return {filter(a.x, b.x, c.x, d.x), filter(a.y, b.y, c.y, d.y), filter(a.z, b.z, c.z, d.z)};
}

// The surface at l = (l1, l2) of a triangle.
template <class F, class Tap>
PLUMB_INLINE Surface<F> surface(const SurfaceArgs& in, index_t<F> triangle, const vec2<F>& l, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    tap("triangle", triangle, "index of the triangle that is seen");
    tap("barycentrics", l, "l1, l2; l0 = 1 - l1 - l2");
    const I corner = triangle * I(3);
    const I v0 = N::fetch(in.triangles, corner) * I(2), v1 = N::fetch(in.triangles, corner + I(1)) * I(2),
            v2 = N::fetch(in.triangles, corner + I(2)) * I(2);
    const vec4<F> p0 = N::fetch4(in.vertices, v0), p1 = N::fetch4(in.vertices, v1), p2 = N::fetch4(in.vertices, v2);
    const vec4<F> n0 = N::fetch4(in.vertices, v0 + I(1)), n1 = N::fetch4(in.vertices, v1 + I(1)),
                  n2 = N::fetch4(in.vertices, v2 + I(1));

    Surface<F> s;
    const vec3<F> e1 = minus3(xyz<F>(p1), xyz<F>(p0)), e2 = minus3(xyz<F>(p2), xyz<F>(p0));
    s.position = interpolate3(xyz<F>(p0), e1, e2, l);                tap("position", s.position, "world, m");

    const vec3<F> to_viewer{F(in.viewer[0]) - F(in.viewer[3]) * p0.x, F(in.viewer[1]) - F(in.viewer[3]) * p0.y,
                            F(in.viewer[2]) - F(in.viewer[3]) * p0.z};
    const vec3<F> interpolated = interpolate3(xyz<F>(n0), minus3(xyz<F>(n1), xyz<F>(n0)),
                                              minus3(xyz<F>(n2), xyz<F>(n0)), l);
    s.normal = viewed_normal(interpolated, face_normal(e1, e2), to_viewer);
    tap("normal", s.normal, "unit, on the side that is seen");

    const I material = N::fetch(in.material, triangle);              tap("material", material, "its index");
    const vec3<F> reflectance = xyz<F>(N::fetch4(in.materials, material * I(4)));
    s.emission = xyz<F>(N::fetch4(in.materials, material * I(4) + I(1)));
    tap("reflectance", reflectance, "of the material");
    s.albedo = reflectance;
    const I texture = N::fetch(in.material_texture, material);
    if (any(texture > I(0))) {
        const vec2<F> uv{interpolate(p0.w, p1.w - p0.w, p2.w - p0.w, l),
                         interpolate(n0.w, n1.w - n0.w, n2.w - n0.w, l)};
        tap("uv", uv, "(0, 0) is the top left of the image");
        const vec3<F> colour = sample_texture(in, texture, uv, tap); tap("texture", colour, "linear");
        // Lanes without a texture take the reflectance itself: for them, coordinates that overflow would give NaN.
        const vec3<F> tinted{reflectance.x * colour.x, reflectance.y * colour.y, reflectance.z * colour.z};
        s.albedo = select3<F>(texture > I(0), tinted, reflectance);
    }
    tap("albedo", s.albedo, "rho");
    tap("emission", s.emission, "M, W/m2");
    return s;
}

// Distance of x from the viewer's plane along the view direction, m. ISR 4.2: linear eye z, not divided by the far
// plane.
template <class F>
PLUMB_INLINE F linear_depth(const float* eye, const float* forward, const vec3<F>& x) {
    const vec3<F> d{x.x - F(eye[0]), x.y - F(eye[1]), x.z - F(eye[2])};
    return F(forward[0]) * d.x + F(forward[1]) * d.y + F(forward[2]) * d.z;
}

}  // namespace plumb::raster
