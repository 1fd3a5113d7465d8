// Which triangle each texel of a hemicube sees (HEM 4.5.3, 5.6; Cohen and Greenberg 1985): the algorithm that items.comp
// mirrors line by line. items_isa.cpp draws triangle by triangle and gives the same bits.
//
// Nothing is projected. The plane through the eye and an edge of a triangle is linear in a face's coordinates x and y
// (Olano and Greer 1997, "Triangle Scan Conversion using 2D Homogeneous Coordinates"):
//
//     e_k(x, y) = (P_k+1 x P_k+2) . (x, y, 1)     a texel is covered where the signs of e_0, e_1, e_2 are that of the volume
//     1/depth   = N . (x, y, 1) / (N . P_0)       N = (P_1 - P_0) x (P_2 - P_0)      both before anything is turned: of a far
//                                                 corner turning leaves eps of its distance, across the plane, too
//     b_k       = e_k / (e_0 + e_1 + e_2)         barycentrics
//
// so there is no near plane and nothing is clipped, and of two triangles that share an edge both ask the same number: no
// texel falls between them, and one on the edge is the nearer's, of equals the first one's.
//
//            top: size x size, seen along n             four sides: size x size/2 each, u, -u, t, -t upwards n
//
// differs: HEM draws what is in front of a near plane "one unit" off the surface; a GPU rounds corners to 1/256 of a texel
// (raster/hemicube.h does).
#pragma once

#include "core/number.h"
#include "core/store_index.h"
#include "raster/surface_kernel.h"

namespace plumb::radiosity {

inline constexpr int rows_of_hemicube(int size) { return 3 * size; }

// The twin's uniform block (std140).
struct ItemsUniforms {
    std::int32_t width, height;  // texels of a face's side; of all rows of all hemicubes
    std::int32_t vertices, triangles;
    float texel;                 // 2 / width: of a face's coordinates
    float slack;                 // how far beyond its corners a triangle may reach, of the same: what rounding moves
    std::int32_t padding[2];
};
static_assert(sizeof(ItemsUniforms) == 32);

struct ItemsView {
    ItemsUniforms u;
    const float* eyes;               // [height / (3 width)][4][4]: xyz of the eye, m; u; t; n
    const float* vertices;           // [vertex][4]: xyz m
    const std::int32_t* triangles;   // [triangle][4]: corners
    std::int32_t* triangle;          // out: [height][width]
    float* seen;                     // out: [height][width][4]
};

// A texel: the hemicube that it is of, the face, and its centre there, -1..1.
template <class F>
struct Texel {
    index_t<F> hemicube, face;
    F x, y;
};

template <class F>
PLUMB_INLINE Texel<F> texel_at(const ItemsUniforms& u, index_t<F> column, index_t<F> line) {
    using N = number<F>;
    using I = index_t<F>;
    const int rows = rows_of_hemicube(u.width), half = u.width / 2;
    Texel<F> t;
    t.hemicube = N::truncate_to_index((N::from_index(line) + F(0.5f)) / F(float(rows)));
    const I row = line - t.hemicube * I(rows);
    const I zero(0), one(1);
    t.face = select(row < I(u.width), zero, one) + select(row < I(u.width + half), zero, one) +
             select(row < I(2 * u.width), zero, one) + select(row < I(2 * u.width + half), zero, one);
    const I own = row - select(t.face == zero, zero, I(u.width) + (t.face - one) * I(half));
    t.x = (N::from_index(column) + F(0.5f)) * F(u.texel) - F(1.0f);
    t.y = F(1.0f) - (N::from_index(own) + F(0.5f)) * F(u.texel);
    return t;
}

// From the axes of a hemicube (along u, t, n) to a face's (right, up, forward). Signs and order alone: exact.
template <class F>
PLUMB_INLINE vec3<F> turned(const vec3<F>& p, index_t<F> face) {
    using I = index_t<F>;
    const mask_t<F> top = face == I(0), u = face == I(1), minus_u = face == I(2), t = face == I(3);
    return {select(top | minus_u, -p.y, select(u, p.y, select(t, -p.x, p.x))), select(top, p.x, p.z),
            select(top, p.z, select(u, p.x, select(minus_u, -p.x, select(t, p.y, -p.y))))};
}

template <class F>
PLUMB_INLINE F plane_at(const vec3<F>& e, F x, F y) {
    return e.x * x + (e.y * y + e.z);
}

// The axes of a hemicube as vectors, and what lies there in them.
template <class F>
struct Eye {
    vec3<F> at, u, t, n;
    PLUMB_INLINE vec3<F> turned(const vec3<F>& d) const { return {dot3(d, u), dot3(d, t), dot3(d, n)}; }
    PLUMB_INLINE vec3<F> local(const vec3<F>& p) const { return turned(raster::minus3(p, at)); }
};

PLUMB_INLINE bool has_corners(const std::int32_t* corner, int vertices) {
    return in_range(corner[0], vertices) && in_range(corner[1], vertices) && in_range(corner[2], vertices);
}

// Three edges and the plane of a triangle in the axes of a hemicube.
template <class F>
struct Planes {
    vec3<F> e0, e1, e2, normal;
    F volume;  // N . P_0, m3: above 0 where its front is seen
};

// N, as the scene's axes have it: u, t, n are left-handed, so that it is the other way round.
template <class F>
PLUMB_INLINE vec3<F> normal_of(const vec3<F>& v0, const vec3<F>& v1, const vec3<F>& v2) {
    return raster::cross3(raster::minus3(v2, v0), raster::minus3(v1, v0));
}

// Of corners as the hemicube's axes have them; the normal and corner 0 as the scene's have them.
template <class F>
PLUMB_INLINE Planes<F> planes_of(const vec3<F>& p0, const vec3<F>& p1, const vec3<F>& p2, const vec3<F>& normal, const vec3<F>& v0,
                                 const Eye<F>& eye) {
    using raster::cross3;
    Planes<F> s;
    s.e0 = cross3(p1, p2), s.e1 = cross3(p2, p0), s.e2 = cross3(p0, p1);
    s.normal = eye.turned(normal);
    s.volume = dot3(normal, raster::minus3(v0, eye.at));
    return s;
}

// Whether a face sees anything of corners given in its axes: not all lie behind it, below the surface's plane, or beyond
// the same border.
template <class F>
PLUMB_INLINE mask_t<F> reaches(const vec3<F>& a, const vec3<F>& b, const vec3<F>& c, const mask_t<F>& above) {
    const F zero(0.0f);
    return above & ((a.z > zero) | (b.z > zero) | (c.z > zero)) & !((a.x > a.z) & (b.x > b.z) & (c.x > c.z)) &
           !((-a.x > a.z) & (-b.x > b.z) & (-c.x > c.z)) & !((a.y > a.z) & (b.y > b.z) & (c.y > c.z)) &
           !((-a.y > a.z) & (-b.y > b.z) & (-c.y > c.z));
}

// Where on the face a triangle may lie: as its corners say, where all are in front of the eye.
template <class F>
struct Bounds {
    F left, right, bottom, top;
};

template <class F>
PLUMB_INLINE Bounds<F> bounds_of(const vec3<F>& a, const vec3<F>& b, const vec3<F>& c, F slack) {
    const F zero(0.0f), far(4.0f);
    const mask_t<F> front = (a.z > zero) & (b.z > zero) & (c.z > zero);
    const F ax = a.x / a.z, bx = b.x / b.z, cx = c.x / c.z, ay = a.y / a.z, by = b.y / b.z, cy = c.y / c.z;
    return {select(front, min(min(ax, bx), cx) - slack, -far), select(front, max(max(ax, bx), cx) + slack, far),
            select(front, min(min(ay, by), cy) - slack, -far), select(front, max(max(ay, by), cy) + slack, far)};
}

// What a texel sees of a triangle.
template <class F>
struct Crossing {
    mask_t<F> covered, front;
    F nearness;  // 1 / depth along the face's axis, 1/m
};

template <class F>
PLUMB_INLINE Crossing<F> crossing(F e0, F e1, F e2, F plane, F volume, F inverse_volume) {
    const F zero(0.0f);
    Crossing<F> c;
    c.front = volume > zero;
    c.nearness = plane * inverse_volume;
    c.covered = ((c.front & (e0 >= zero) & (e1 >= zero) & (e2 >= zero)) |
                 ((volume < zero) & (e0 <= zero) & (e1 <= zero) & (e2 <= zero))) &
                (c.nearness > zero);
    return c;
}

// Barycentrics of corners 1 and 2.
template <class F>
PLUMB_INLINE vec2<F> barycentrics_of(F e0, F e1, F e2) {
    const F sum = abs(e0) + abs(e1) + abs(e2), scale = F(1.0f) / select(sum > F(0.0f), sum, F(1.0f));
    return {abs(e1) * scale, abs(e2) * scale};
}

template <class F>
struct Item {
    index_t<F> triangle;  // -1: none
    vec4<F> seen;         // barycentrics of corners 1 and 2, 1/depth in 1/m, and 1: its front, -1: its back, 0: nothing
    template <class Each>
    void components(Each each) const {
        each(number<F>::from_index(triangle)), each(seen.x), each(seen.y), each(seen.z), each(seen.w);
    }
};

template <class F, class Tap>
PLUMB_INLINE Item<F> item(const ItemsView& in, index_t<F> column, index_t<F> line, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const Texel<F> at = texel_at<F>(in.u, column, line);
    tap("face", at.face, "top, u, -u, t, -t"), tap("x", at.x, "of the texel's centre, -1..1"), tap("y", at.y, "up");
    const I first = at.hemicube * I(4);
    const Eye<F> eye{xyz<F>(N::fetch4(in.eyes, first)), xyz<F>(N::fetch4(in.eyes, first + I(1))),
                     xyz<F>(N::fetch4(in.eyes, first + I(2))), xyz<F>(N::fetch4(in.eyes, first + I(3)))};
    const F zero(0.0f);
    Item<F> nearest{I(-1), {zero, zero, zero, zero}};
    for (int i = 0; i < in.u.triangles; ++i) {
        const std::int32_t* corner = in.triangles + 4 * std::ptrdiff_t(i);
        if (!has_corners(corner, in.u.vertices)) continue;
        const vec3<F> v0 = xyz<F>(N::fetch4(in.vertices, I(corner[0]))), v1 = xyz<F>(N::fetch4(in.vertices, I(corner[1]))),
                      v2 = xyz<F>(N::fetch4(in.vertices, I(corner[2])));
        const vec3<F> p0 = eye.local(v0), p1 = eye.local(v1), p2 = eye.local(v2);
        const mask_t<F> above = (p0.z > zero) | (p1.z > zero) | (p2.z > zero);
        const vec3<F> q0 = turned<F>(p0, at.face), q1 = turned<F>(p1, at.face), q2 = turned<F>(p2, at.face);
        const Bounds<F> b = bounds_of<F>(q0, q1, q2, F(in.u.slack));
        const mask_t<F> within = reaches<F>(q0, q1, q2, above) & (b.left <= at.x) & (at.x <= b.right) & (b.bottom <= at.y) & (at.y <= b.top);
        if (!any(within)) continue;
        tap.sample(i);
        const Planes<F> s = planes_of<F>(p0, p1, p2, normal_of<F>(v0, v1, v2), v0, eye);
        const F e0 = plane_at<F>(turned<F>(s.e0, at.face), at.x, at.y), e1 = plane_at<F>(turned<F>(s.e1, at.face), at.x, at.y),
                e2 = plane_at<F>(turned<F>(s.e2, at.face), at.x, at.y),
                plane = plane_at<F>(turned<F>(s.normal, at.face), at.x, at.y);
        tap("volume", s.volume, "N . P_0, m3: above 0 where its front is seen");
        tap("e", vec3<F>(e0, e1, e2), "(P_k+1 x P_k+2) . (x, y, 1), m2");
        const Crossing<F> c = crossing<F>(e0, e1, e2, plane, s.volume, F(1.0f) / s.volume);
        tap("nearness", c.nearness, "1 / depth, 1/m");
        const mask_t<F> takes = within & c.covered & (c.nearness > nearest.seen.z);
        const vec2<F> bary = barycentrics_of<F>(e0, e1, e2);
        nearest.triangle = select(takes, I(i), nearest.triangle);
        nearest.seen = {select(takes, bary.x, nearest.seen.x), select(takes, bary.y, nearest.seen.y),
                        select(takes, c.nearness, nearest.seen.z),
                        select(takes, select(c.front, F(1.0f), F(-1.0f)), nearest.seen.w)};
    }
    tap.sample(-1);
    tap("triangle", nearest.triangle, "that the texel sees; -1: none");
    tap("seen", xyz<F>(nearest.seen), "barycentrics of corners 1 and 2; 1/depth, 1/m");
    tap("side", nearest.seen.w, "1: its front, -1: its back, 0: nothing");
    return nearest;
}

// Triangles whose corners there are, in the order in which they are drawn.
struct DrawList {
    static constexpr int pad = 16;          // the last ones have no area, so that packets of any width are whole
    const std::int32_t* corner[3];          // [count]
    const std::int32_t* number;             // [count]: which triangle it is
    const float* plane[6];                  // [count]: xyz of N and of corner 0, as the scene has them
    int count;                              // a multiple of pad
    static PLUMB_INLINE std::size_t padded(std::size_t triangles) { return (triangles + pad - 1) / pad * pad; }
};

// Memory that a hemicube is drawn in, floats.
struct DrawMemory {
    float* turned;       // [vertices][4]: along u, t, n, and which borders of faces it is beyond
    float* centre;       // [size]: of columns
    float* nearness;     // [3 size][size]
    float *b1, *b2;      // the same: barycentrics
    std::int32_t* seen;  // the same: twice the triangle's number, 1 more where it is its back; -1: none

    static PLUMB_INLINE std::size_t padded(std::size_t n) { return (n + 31) / 16 * 16; }
    static PLUMB_INLINE std::size_t texels(int size) { return padded(std::size_t(rows_of_hemicube(size)) * std::size_t(size)); }
    static PLUMB_INLINE std::size_t floats(int vertices, int size) {
        return 4 * padded(std::size_t(vertices)) + padded(std::size_t(size)) + 4 * texels(size);
    }
    PLUMB_INLINE DrawMemory(float* memory, int vertices, int size) {
        turned = memory, centre = turned + 4 * padded(std::size_t(vertices)), nearness = centre + padded(std::size_t(size));
        b1 = nearness + texels(size), b2 = b1 + texels(size), seen = reinterpret_cast<std::int32_t*>(b2 + texels(size));
    }
};

struct ItemsKernel {
    using View = ItemsView;
    static constexpr int band = 96;
    static std::size_t scratch(const View& in, int) {
        return DrawMemory::floats(in.u.vertices, in.u.width) + 10 * DrawList::padded(std::size_t(in.u.triangles));
    }
    template <class F, class Tap>
    PLUMB_INLINE static Item<F> item(const View& in, index_t<F> column, index_t<F> line, Tap& tap) {
        return radiosity::item<F>(in, column, line, tap);
    }
    template <class F>
    PLUMB_INLINE static void store(const View& in, index_t<F> at, const Item<F>& i, mask_t<F> active) {
        store_index<F>(in.triangle, at, i.triangle, active);
        number<F>::store4(in.seen, at, i.seen, active);
    }
};

}  // namespace plumb::radiosity
