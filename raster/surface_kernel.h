// A point of a triangle: position, normal and material, interpolated by barycentric coordinates; surface.glsl is the
// twin, line by line. Shared by gbuffer_kernel.h and rsm_kernel.h. Equations: README.md, "Textures and normal maps".
#pragma once

#include "raster/texture_kernel.h"

namespace plumb::raster {

// What the kernels read of geometry and surfaces (raster/surfaces.h).
struct SurfaceArgs {
    const float* vertices;          // [vertex][8]: position m, u, normal, v
    const float* tangents;          // [vertex][4]: xyz, w = side of the bitangent; read for materials with a normal map
    const std::int32_t* triangles;  // [triangle][3]
    const std::int32_t* material;   // [triangle]
    const float* materials;         // [material][16]: reflectance, alpha; emission W/m2, alpha cutoff;
                                    // rows of `textures` (base, emission, normal), scale of the normal; padding
    TextureArgs textures;
    float viewer[4];                // xyz m, w 1: where the viewer is; w 0: the direction towards it
    float forward[3];               // unit: where the viewer looks
    float pixel_area;               // of a pixel: at depth 1 m, m2/m2; parallel projection: m2
};

template <class F>
struct Surface {
    vec3<F> position;  // m
    vec3<F> normal;    // unit, on the side of the triangle that the viewer sees
    vec3<F> face;      // the triangle's own normal, by its winding, of any length
    F extent;          // largest |coordinate| of its corners, m
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

template <class F>
PLUMB_INLINE vec3<F> cross3(const vec3<F>& a, const vec3<F>& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
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
    return cross3(vec3<F>(e1.x * scale, e1.y * scale, e1.z * scale), vec3<F>(e2.x * scale, e2.y * scale, e2.z * scale));
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
    index_t<F> base, emission, normal;  // rows of the textures; 0: none
    F normal_scale;
};

// Every lane's index where all have the same, so that data may be read once and shared; else, and for one lane, -1.
template <class F>
PLUMB_INLINE std::int32_t shared_index(index_t<F> i) {
    if (number<F>::width == 1) return -1;
    std::int32_t lane0;
    std::memcpy(&lane0, &i, sizeof lane0);
    return any(!(i == index_t<F>(lane0))) ? -1 : lane0;
}

// A vertex as it lies in memory: position and u, normal and v.
template <class F>
struct Corner {
    vec4<F> p, n;
};
template <class F>
struct Corners {
    index_t<F> v0, v1, v2;
    Corner<F> a, b, c;
};
template <class F>
PLUMB_INLINE Corner<F> shared_corner(const float* vertex) {
    return {{F(vertex[0]), F(vertex[1]), F(vertex[2]), F(vertex[3])},
            {F(vertex[4]), F(vertex[5]), F(vertex[6]), F(vertex[7])}};
}
template <class F>
PLUMB_INLINE Corner<F> fetch_corner(const float* vertices, index_t<F> vertex) {
    using N = number<F>;
    using I = index_t<F>;
    return {N::fetch4(vertices, vertex * I(2)), N::fetch4(vertices, vertex * I(2) + I(1))};
}
template <class F>
PLUMB_INLINE Corners<F> fetch_corners(const SurfaceArgs& in, index_t<F> triangle) {
    using N = number<F>;
    using I = index_t<F>;
    const std::int32_t shared = shared_index<F>(triangle);
    if (shared >= 0) {
        const std::int32_t* v = in.triangles + 3 * std::ptrdiff_t(shared);
        auto corner = [&](int k) { return shared_corner<F>(in.vertices + 8 * std::ptrdiff_t(v[k])); };
        return {I(v[0]), I(v[1]), I(v[2]), corner(0), corner(1), corner(2)};
    }
    const I row = triangle * I(3);
    const I v0 = N::fetch(in.triangles, row), v1 = N::fetch(in.triangles, row + I(1)),
            v2 = N::fetch(in.triangles, row + I(2));
    return {v0, v1, v2, fetch_corner<F>(in.vertices, v0), fetch_corner<F>(in.vertices, v1),
            fetch_corner<F>(in.vertices, v2)};
}

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

template <class F>
PLUMB_INLINE vec3<F> times3(const vec3<F>& a, const vec3<F>& b) {
    return {a.x * b.x, a.y * b.y, a.z * b.z};
}

// The normal that a map asks for, of any length: t.x T + t.y w (N x T) + t.z N, with N and T interpolated and not
// normalised (Mikkelsen 2008). Where vertices have no tangent T is 0, and the map changes nothing but the length.
template <class F, class Tap>
PLUMB_INLINE vec3<F> mapped_normal(const SurfaceArgs& in, const MaterialRow<F>& m, index_t<F> v0, index_t<F> v1,
                                   index_t<F> v2, const vec2<F>& uv, F uv_area, const vec2<F>& l, const vec3<F>& n,
                                   Tap& tap) {
    using N = number<F>;
    const vec4<F> t0 = N::fetch4(in.tangents, v0), t1 = N::fetch4(in.tangents, v1), t2 = N::fetch4(in.tangents, v2);
    const vec3<F> tangent =
        interpolate3(xyz<F>(t0), minus3(xyz<F>(t1), xyz<F>(t0)), minus3(xyz<F>(t2), xyz<F>(t0)), l);
    const F side = interpolate(t0.w, t1.w - t0.w, t2.w - t0.w, l);
    tap("tangent", tangent, "interpolated");
    tap("bitangent_side", side, "w; -1 where the map is mirrored");

    NoTap quiet;
    const vec3<F> texel = sample<F>(in.textures, m.normal, uv, uv_area, true, quiet);
    const F x = (F(2.0f) * texel.x - F(1.0f)) * m.normal_scale, y = (F(2.0f) * texel.y - F(1.0f)) * m.normal_scale;
    const F z = F(2.0f) * texel.z - F(1.0f), w = y * side;
    tap("tangent_normal", vec3<F>(x, y, z), "of the normal map, scaled");
    const vec3<F> across = cross3(n, tangent);
    return {(x * tangent.x + w * across.x) + z * n.x, (x * tangent.y + w * across.y) + z * n.y,
            (x * tangent.z + w * across.z) + z * n.z};
}

// Texture coordinates of a triangle's point.
template <class F>
PLUMB_INLINE vec2<F> interpolate_uv(const vec2<F>& a, const vec2<F>& b, const vec2<F>& c, const vec2<F>& l) {
    return {interpolate(a.x, b.x - a.x, c.x - a.x, l), interpolate(a.y, b.y - a.y, c.y - a.y, l)};
}

// Area in (u, v) that a pixel covers where the triangle's plane is seen at x: README.md, "Level of detail". Infinite or
// not a number where the plane is seen edge-on.
template <class F>
PLUMB_INLINE F pixel_uv_area(const SurfaceArgs& in, const vec2<F>& uv1, const vec2<F>& uv2, const vec3<F>& e1,
                             const vec3<F>& e2, const vec3<F>& to_viewer, const vec3<F>& x) {
    F area(in.pixel_area);
    if (in.viewer[3] > 0) {
        const vec3<F> d{x.x - F(in.viewer[0]), x.y - F(in.viewer[1]), x.z - F(in.viewer[2])};
        const F depth = F(in.forward[0]) * d.x + F(in.forward[1]) * d.y + F(in.forward[2]) * d.z;
        area = area * (depth * depth * depth);
    }
    return area * abs(uv1.x * uv2.y - uv1.y * uv2.x) / abs(dot3(cross3(e1, e2), to_viewer));
}

// Whether there is a surface at all: glTF's alphaMode MASK, by level 0. NaN is none.
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
    const vec2<F> uv = interpolate_uv<F>(uv_of(0), uv_of(1), uv_of(2), l);
    const F alpha = m.reflectance_alpha.w * TextureFilter<F>::alpha(in.textures, m.base, uv);
    const F cutoff = m.emission_cutoff.w;
    return mask_t<F>((!(cutoff > F(0.0f))) | (alpha >= cutoff));
}

// The surface at l = (l1, l2) of a triangle, as `viewer` sees it: xyz m, w 1, or the direction towards it, w 0.
template <class F, class Tap>
PLUMB_INLINE Surface<F> surface(const SurfaceArgs& in, index_t<F> triangle, const vec2<F>& l, const vec4<F>& viewer,
                                Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    tap("triangle", triangle, "index of the triangle that is seen");
    tap("barycentrics", l, "l1, l2; l0 = 1 - l1 - l2");
    const Corners<F> corners = fetch_corners<F>(in, triangle);
    const vec4<F>&p0 = corners.a.p, &p1 = corners.b.p, &p2 = corners.c.p;
    const vec4<F>&n0 = corners.a.n, &n1 = corners.b.n, &n2 = corners.c.n;
    const I material = N::fetch(in.material, triangle);              tap("material", material, "its index");
    const MaterialRow<F> m = fetch_material<F>(in, material);

    Surface<F> s;
    const vec3<F> e1 = minus3(xyz<F>(p1), xyz<F>(p0)), e2 = minus3(xyz<F>(p2), xyz<F>(p0));
    s.position = interpolate3(xyz<F>(p0), e1, e2, l);                tap("position", s.position, "world, m");

    // The interpolated normal, or the face's where vertices have none. Its side is decided before a map bends it: the
    // whole tangent frame turns with the face.
    const vec3<F> to_viewer{viewer.x - viewer.w * p0.x, viewer.y - viewer.w * p0.y, viewer.z - viewer.w * p0.z};
    const vec3<F> interpolated = interpolate3(xyz<F>(n0), minus3(xyz<F>(n1), xyz<F>(n0)),
                                              minus3(xyz<F>(n2), xyz<F>(n0)), l);
    const vec3<F> face = face_normal(e1, e2);
    const mask_t<F> given = dot3(interpolated, interpolated) > F(0.0f);
    vec3<F> n = select3<F>(given, interpolated, face);
    const F side = viewed_side(face, n, to_viewer);

    // Textures, where any lane has one; lanes without read the white texel.
    vec2<F> uv{F(0.0f), F(0.0f)};
    F uv_area(0.0f);
    if (any((m.base | m.emission | m.normal) > I(0))) {
        uv = interpolate_uv<F>({p0.w, n0.w}, {p1.w, n1.w}, {p2.w, n2.w}, l);
        tap("uv", uv, "(0, 0) is the top left of the image");
        if (in.textures.levels) {
            uv_area = pixel_uv_area<F>(in, {p1.w - p0.w, n1.w - n0.w}, {p2.w - p0.w, n2.w - n0.w}, e1, e2, to_viewer,
                                       s.position);
            tap("uv_area", uv_area, "that the pixel covers");
        }
    }
    if (any(m.normal > I(0))) {
        const vec3<F> unit = select3<F>(given, n, normalised(face));
        const vec3<F> bent =
            mapped_normal<F>(in, m, corners.v0, corners.v1, corners.v2, uv, uv_area, l, unit, tap);
        n = select3<F>(m.normal > I(0), bent, n);
    }
    s.normal = normalised(n);
    s.normal = {s.normal.x * side, s.normal.y * side, s.normal.z * side};
    tap("normal", s.normal, "unit, on the side that is seen");

    s.albedo = xyz<F>(m.reflectance_alpha);                          tap("reflectance", s.albedo, "of the material");
    if (any(m.base > I(0))) {
        const vec3<F> colour = sample<F>(in.textures, m.base, uv, uv_area, false, tap);
        tap("texture", colour, "linear");
        s.albedo = times3(s.albedo, colour);
    }
    tap("albedo", s.albedo, "rho");

    s.emission = xyz<F>(m.emission_cutoff);
    if (any(m.emission > I(0))) {
        NoTap quiet;
        s.emission = times3(s.emission, sample<F>(in.textures, m.emission, uv, uv_area, false, quiet));
    }
    tap("emission", s.emission, "M, W/m2");
    s.face = face;
    s.extent = max(largest3(xyz<F>(p0)), max(largest3(xyz<F>(p1)), largest3(xyz<F>(p2))));
    return s;
}

// The same for the one viewer of the arguments.
template <class F, class Tap>
PLUMB_INLINE Surface<F> surface(const SurfaceArgs& in, index_t<F> triangle, const vec2<F>& l, Tap& tap) {
    return surface<F>(in, triangle, l, {F(in.viewer[0]), F(in.viewer[1]), F(in.viewer[2]), F(in.viewer[3])}, tap);
}

// Distance of x from the viewer's plane along the view direction, m. ISR 4.2: linear eye z, not divided by the far
// plane.
template <class F>
PLUMB_INLINE F linear_depth(const float* eye, const float* forward, const vec3<F>& x) {
    const vec3<F> d{x.x - F(eye[0]), x.y - F(eye[1]), x.z - F(eye[2])};
    return F(forward[0]) * d.x + F(forward[1]) * d.y + F(forward[2]) * d.z;
}

}  // namespace plumb::raster
