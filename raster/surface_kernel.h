// A point of a triangle: position, normal and material, interpolated by barycentric coordinates; surface.glsl is the
// twin, line by line. Shared by gbuffer_kernel.h and rsm_kernel.h. Equations: README.md, "Textures and normal maps".
#pragma once

#include "core/number.h"
#include "core/tap.h"

namespace plumb::raster {

// What the kernels read of geometry and surfaces (raster/surfaces.h).
struct SurfaceArgs {
    const float* vertices;          // [vertex][8]: position m, u, normal, v
    const float* tangents;          // [vertex][4]: xyz, w = side of the bitangent; read for materials with a normal map
    const std::int32_t* triangles;  // [triangle][3]
    const std::int32_t* material;   // [triangle]
    const float* materials;         // [material][16]: reflectance, alpha; emission W/m2, alpha cutoff;
                                    // rows of `textures` (base, emission, normal), scale of the normal; padding
    const std::int32_t* textures;   // [texture][4]: first texel, width, height, flags; row 0 is one white texel
    const std::int32_t* texels;     // RGBA8
    const float* decode;            // [2][256]
    float viewer[4];                // xyz m, w 1: where the viewer is; w 0: the direction towards it
};

// A texture's flags: wrap modes are numbered as in core/scene.h, two bits along u and two along v.
inline constexpr std::int32_t flag_nearest = 1, flag_srgb = 2;
inline constexpr int wrap_u_shift = 2, wrap_v_shift = 4;

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

// +1 or -1: turns normal n to the side of the face that is towards `to_viewer`. Turning by the face and not by the
// normal itself keeps shading smooth where a curved surface bends away.
template <class F>
PLUMB_INLINE F viewed_side(const vec3<F>& face, const vec3<F>& n, const vec3<F>& to_viewer) {
    return side_of(dot3(face, to_viewer)) * side_of(dot3(face, n));
}

// Of unit length; 0 stays.
template <class F>
PLUMB_INLINE vec3<F> normalised(const vec3<F>& n) {
    const F length = max(sqrt(dot3(n, n)), F(1e-30f));
    return {n.x / length, n.y / length, n.z / length};
}

template <class F>
struct MaterialRow {
    vec4<F> reflectance_alpha, emission_cutoff;
    index_t<F> base, emission, normal;  // rows of `textures`; 0: none
    F normal_scale;
};

// The material of each lane. Most packets see one: it is read once and shared.
template <class F>
PLUMB_INLINE MaterialRow<F> fetch_material(const SurfaceArgs& in, index_t<F> material) {
    using N = number<F>;
    using I = index_t<F>;
    std::int32_t lane0;
    std::memcpy(&lane0, &material, sizeof lane0);
    Record<F> r;
    if (any(!(material == I(lane0)))) {
        r = N::fetch_record(in.materials, material);
    } else {
        const float* m = in.materials + record_stride * std::ptrdiff_t(lane0);
        r = {{F(m[0]), F(m[1]), F(m[2]), F(m[3])}, {F(m[4]), F(m[5]), F(m[6]), F(m[7])},
             {F(m[8]), F(m[9]), F(m[10]), F(m[11])}};
    }
    return {r.a, r.b, N::truncate_to_index(r.c.x), N::truncate_to_index(r.c.y), N::truncate_to_index(r.c.z), r.c.w};
}

// Coordinate u in texels, within one period: texel centres lie at whole numbers when filtering; nearest takes the whole
// part. Repeat has the period 1, mirrored repeat 2. What is not finite becomes texel 0 with weight 0.
template <class F>
PLUMB_INLINE F texel_coordinate(F u, index_t<F> size, index_t<F> wrap, mask_t<F> nearest) {
    using N = number<F>;
    using I = index_t<F>;
    const mask_t<F> mirrored = wrap == I(1), clamped = wrap == I(2);
    const F periods = u * select(mirrored, F(0.5f), F(1.0f));
    const F within = select(clamped, clamp(u, F(0.0f), F(1.0f)), periods - floor(periods));
    const F texels = within * N::from_index(select(mirrored, size + size, size));
    const F coordinate = select(nearest, floor(texels), texels - F(0.5f));
    return select(abs(u) <= F(0x1.fffffep127f), coordinate, F(0.0f));
}

// The texel that index i, from -1 to one period + 1, stands for (Vulkan 1.3, 16.6.2 "Wrapping Operation"). The last
// clamp is clamp_to_edge, and keeps every read inside the image.
template <class F>
PLUMB_INLINE index_t<F> wrap_index(index_t<F> i, index_t<F> size, index_t<F> wrap) {
    using I = index_t<F>;
    const auto mirrored = wrap == I(1), clamped = wrap == I(2);
    const I below = select(mirrored, I(-1) - i, i + size);
    const I above = select(mirrored, size + size - I(1) - i, i - size);
    const I folded = select(i < I(0), below, select(i < size, i, above));
    return min(max(select(clamped, i, folded), I(0)), size - I(1));
}

// The four texels that a lookup reads (upper left, upper right, lower left, lower right), and the weights of the right
// and of the lower ones.
template <class F>
struct TexelQuad {
    index_t<F> a, b, c, d;  // RGBA8
    F along_u, along_v;
    index_t<F> curve;       // where the texture's decode table starts
};

template <class F, class Tap>
PLUMB_INLINE TexelQuad<F> fetch_quad(const SurfaceArgs& in, index_t<F> texture, const vec2<F>& uv, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const I row = texture * I(4);
    const I first = N::fetch(in.textures, row), width = N::fetch(in.textures, row + I(1));
    const I height = N::fetch(in.textures, row + I(2)), flags = N::fetch(in.textures, row + I(3));
    const I wrap_u = shift_right(flags, wrap_u_shift) & I(3), wrap_v = shift_right(flags, wrap_v_shift) & I(3);
    const mask_t<F> nearest = (flags & I(flag_nearest)) > I(0);

    const F x = texel_coordinate<F>(uv.x, width, wrap_u, nearest), y = texel_coordinate<F>(uv.y, height, wrap_v, nearest);
    const F left = floor(x), top = floor(y);
    const I i = N::truncate_to_index(left), j = N::truncate_to_index(top);
    const I x0 = wrap_index<F>(i, width, wrap_u), x1 = wrap_index<F>(i + I(1), width, wrap_u);
    const I upper = first + wrap_index<F>(j, height, wrap_v) * width;
    const I lower = first + wrap_index<F>(j + I(1), height, wrap_v) * width;
    tap("texel", ivec2<I>{i, j}, "upper left of the texels that are read, before wrapping");
    tap("texel_weight", vec2<F>{x - left, y - top}, "of the right and the lower texels");
    return {N::fetch(in.texels, upper + x0), N::fetch(in.texels, upper + x1),
            N::fetch(in.texels, lower + x0), N::fetch(in.texels, lower + x1),
            x - left, y - top, (flags & I(flag_srgb)) << 7};
}

// One channel: decoded, then filtered, along u first. channel: 0 red .. 3 alpha.
template <class F>
PLUMB_INLINE F filter_channel(const SurfaceArgs& in, const TexelQuad<F>& q, index_t<F> curve, int channel) {
    using I = index_t<F>;
    auto value = [&](I texel) {
        return number<F>::fetch(in.decode, curve + (shift_right(texel, 8 * channel) & I(255)));
    };
    const F a = value(q.a), b = value(q.b), c = value(q.c), d = value(q.d);
    const F upper = a + q.along_u * (b - a), lower = c + q.along_u * (d - c);
    return upper + q.along_v * (lower - upper);
}
template <class F>
PLUMB_INLINE vec3<F> filter_rgb(const SurfaceArgs& in, const TexelQuad<F>& q, index_t<F> curve) {
    return {filter_channel(in, q, curve, 0), filter_channel(in, q, curve, 1), filter_channel(in, q, curve, 2)};
}

template <class F>
PLUMB_INLINE vec3<F> times3(const vec3<F>& a, const vec3<F>& b) {
    return {a.x * b.x, a.y * b.y, a.z * b.z};
}

// The normal that a map asks for, of any length: t.x T + t.y w (N x T) + t.z N, with N and T interpolated and not
// normalised (Mikkelsen 2008). Where vertices have no tangent T is 0, and the map changes nothing but the length.
template <class F, class Tap>
PLUMB_INLINE vec3<F> mapped_normal(const SurfaceArgs& in, const MaterialRow<F>& m, index_t<F> v0, index_t<F> v1,
                                   index_t<F> v2, const vec2<F>& uv, const vec2<F>& l, const vec3<F>& n, Tap& tap) {
    using N = number<F>;
    const vec4<F> t0 = N::fetch4(in.tangents, v0), t1 = N::fetch4(in.tangents, v1), t2 = N::fetch4(in.tangents, v2);
    const vec3<F> tangent =
        interpolate3(xyz<F>(t0), minus3(xyz<F>(t1), xyz<F>(t0)), minus3(xyz<F>(t2), xyz<F>(t0)), l);
    const F side = interpolate(t0.w, t1.w - t0.w, t2.w - t0.w, l);
    tap("tangent", tangent, "interpolated");
    tap("bitangent_side", side, "w; -1 where the map is mirrored");

    NoTap quiet;
    const TexelQuad<F> q = fetch_quad<F>(in, m.normal, uv, quiet);
    const vec3<F> texel = filter_rgb<F>(in, q, index_t<F>(0));
    const F x = (F(2.0f) * texel.x - F(1.0f)) * m.normal_scale, y = (F(2.0f) * texel.y - F(1.0f)) * m.normal_scale;
    const F z = F(2.0f) * texel.z - F(1.0f), w = y * side;
    tap("tangent_normal", vec3<F>(x, y, z), "of the normal map, scaled");
    const vec3<F> across{n.y * tangent.z - n.z * tangent.y, n.z * tangent.x - n.x * tangent.z,
                         n.x * tangent.y - n.y * tangent.x};
    return {(x * tangent.x + w * across.x) + z * n.x, (x * tangent.y + w * across.y) + z * n.y,
            (x * tangent.z + w * across.z) + z * n.z};
}

// Texture coordinates of a triangle's point.
template <class F>
PLUMB_INLINE vec2<F> interpolate_uv(const vec2<F>& a, const vec2<F>& b, const vec2<F>& c, const vec2<F>& l) {
    return {interpolate(a.x, b.x - a.x, c.x - a.x, l), interpolate(a.y, b.y - a.y, c.y - a.y, l)};
}

// Whether there is a surface at all: glTF's alphaMode MASK. NaN is none.
template <class F>
PLUMB_INLINE mask_t<F> passes_alpha(const SurfaceArgs& in, index_t<F> triangle, const vec2<F>& l) {
    using N = number<F>;
    using I = index_t<F>;
    const MaterialRow<F> m = fetch_material<F>(in, N::fetch(in.material, triangle));
    const I corner = triangle * I(3);
    auto uv_of = [&](int k) -> vec2<F> {
        const I vertex = N::fetch(in.triangles, corner + I(k)) * I(8);
        return {N::fetch(in.vertices, vertex + I(3)), N::fetch(in.vertices, vertex + I(7))};
    };
    NoTap quiet;
    const TexelQuad<F> q = fetch_quad<F>(in, m.base, interpolate_uv<F>(uv_of(0), uv_of(1), uv_of(2), l), quiet);
    const F alpha = m.reflectance_alpha.w * filter_channel(in, q, I(0), 3), cutoff = m.emission_cutoff.w;
    return mask_t<F>((!(cutoff > F(0.0f))) | (alpha >= cutoff));
}

// The surface at l = (l1, l2) of a triangle.
template <class F, class Tap>
PLUMB_INLINE Surface<F> surface(const SurfaceArgs& in, index_t<F> triangle, const vec2<F>& l, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    tap("triangle", triangle, "index of the triangle that is seen");
    tap("barycentrics", l, "l1, l2; l0 = 1 - l1 - l2");
    const I corner = triangle * I(3);
    const I v0 = N::fetch(in.triangles, corner), v1 = N::fetch(in.triangles, corner + I(1)),
            v2 = N::fetch(in.triangles, corner + I(2));
    const vec4<F> p0 = N::fetch4(in.vertices, v0 * I(2)), p1 = N::fetch4(in.vertices, v1 * I(2)),
                  p2 = N::fetch4(in.vertices, v2 * I(2));
    const vec4<F> n0 = N::fetch4(in.vertices, v0 * I(2) + I(1)), n1 = N::fetch4(in.vertices, v1 * I(2) + I(1)),
                  n2 = N::fetch4(in.vertices, v2 * I(2) + I(1));
    const I material = N::fetch(in.material, triangle);              tap("material", material, "its index");
    const MaterialRow<F> m = fetch_material<F>(in, material);

    Surface<F> s;
    const vec3<F> e1 = minus3(xyz<F>(p1), xyz<F>(p0)), e2 = minus3(xyz<F>(p2), xyz<F>(p0));
    s.position = interpolate3(xyz<F>(p0), e1, e2, l);                tap("position", s.position, "world, m");

    // The interpolated normal, or the face's where vertices have none. Its side is decided before a map bends it: the
    // whole tangent frame turns with the face.
    const vec3<F> to_viewer{F(in.viewer[0]) - F(in.viewer[3]) * p0.x, F(in.viewer[1]) - F(in.viewer[3]) * p0.y,
                            F(in.viewer[2]) - F(in.viewer[3]) * p0.z};
    const vec3<F> interpolated = interpolate3(xyz<F>(n0), minus3(xyz<F>(n1), xyz<F>(n0)),
                                              minus3(xyz<F>(n2), xyz<F>(n0)), l);
    const vec3<F> face = face_normal(e1, e2);
    const mask_t<F> given = dot3(interpolated, interpolated) > F(0.0f);
    vec3<F> n = select3<F>(given, interpolated, face);
    const F side = viewed_side(face, n, to_viewer);

    // Textures, where any lane has one; lanes without read the white texel.
    vec2<F> uv{F(0.0f), F(0.0f)};
    if (any((m.base | m.emission | m.normal) > I(0))) {
        uv = interpolate_uv<F>({p0.w, n0.w}, {p1.w, n1.w}, {p2.w, n2.w}, l);
        tap("uv", uv, "(0, 0) is the top left of the image");
    }
    if (any(m.normal > I(0))) {
        const vec3<F> unit = select3<F>(given, n, normalised(face));
        n = select3<F>(m.normal > I(0), mapped_normal<F>(in, m, v0, v1, v2, uv, l, unit, tap), n);
    }
    s.normal = normalised(n);
    s.normal = {s.normal.x * side, s.normal.y * side, s.normal.z * side};
    tap("normal", s.normal, "unit, on the side that is seen");

    s.albedo = xyz<F>(m.reflectance_alpha);                          tap("reflectance", s.albedo, "of the material");
    if (any(m.base > I(0))) {
        const TexelQuad<F> q = fetch_quad<F>(in, m.base, uv, tap);
        const vec3<F> colour = filter_rgb<F>(in, q, q.curve);        tap("texture", colour, "linear");
        s.albedo = times3(s.albedo, colour);
    }
    tap("albedo", s.albedo, "rho");

    s.emission = xyz<F>(m.emission_cutoff);
    if (any(m.emission > I(0))) {
        NoTap quiet;
        const TexelQuad<F> q = fetch_quad<F>(in, m.emission, uv, quiet);
        s.emission = times3(s.emission, filter_rgb<F>(in, q, q.curve));
    }
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
