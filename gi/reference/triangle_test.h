// A ray against a triangle in double precision: the same bits on every processor, and no ray slips between triangles
// that share an edge or a corner.
//
// After Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection", JCGT 2013: the axis along which the direction is
// longest becomes z, corners are moved so that the ray starts at the origin, and sheared so that it runs along z. What
// is left is a question in the plane: does the triangle contain (0, 0)? With P x Q = P.x Q.y - P.y Q.x,
//     U = C x B,  V = A x C,  W = B x A;   inside: U, V, W all >= 0, or all <= 0;   D = U + V + W.
// differs: products are of doubles throughout, not only where a float product vanishes.
//
// Why it is watertight. A corner's place in the plane is a function of the corner and the ray alone, so neighbouring
// triangles agree on it, and the sheared triangles are a mesh without gaps wherever the triangles were one. P x Q is a
// difference of two rounded products; rounding keeps order, so the computed difference never has the wrong sign: where
// the exact one is positive, it is positive or 0. 0 counts as inside. So (0, 0) is found inside each triangle that
// contains it exactly, and in a mesh without gaps one does. (The triple products d . (P x Q) of space do not have this
// property: the sum of three products may have any sign where it should be 0.) P x Q = -(Q x P) to the last bit.
//
// t = (U A.z + V B.z + W C.z) / (D d.z) is a weighted mean of the corners' own t: it stays among them, however thin the
// triangle is and however flat the ray meets it. dot(a - o, n) / dot(d, n) would not, and bounds could not hold it.
#pragma once

#include <cmath>
#include <cstdint>

#include "core/number.h"

namespace plumb::reference {

// One triangle, alone on three quarters of a cache line.
struct alignas(16) Corners {
    float a[4], b[4], c[4];  // xyz, m; the last is not used
};

// A ray as the test needs it: axes x, y, z are the world's, turned so that z is the longest of the direction.
struct ShearedRay {
    double origin[3];         // m
    double shear_x, shear_y;  // d.x / d.z, d.y / d.z
    double scale;             // 1 / d.z
    int axis[3];              // the world's axes that x, y, z are
};

PLUMB_INLINE ShearedRay shear(float ox, float oy, float oz, float dx, float dy, float dz) {
    const double o[3] = {ox, oy, oz}, d[3] = {dx, dy, dz};
    int z = std::abs(d[1]) > std::abs(d[0]) ? 1 : 0;
    if (std::abs(d[2]) > std::abs(d[z])) z = 2;
    const int x = z == 2 ? 0 : z + 1, y = x == 2 ? 0 : x + 1;
    return {{o[x], o[y], o[z]}, d[x] / d[z], d[y] / d[z], 1 / d[z], {x, y, z}};
}

struct TriangleHit {
    float t;     // along the direction; the unit is its length
    float u, v;  // weights of b and c
};

// Whether the whole line of the ray meets the triangle. Nothing does where the triangle is seen edge-on, or is not
// finite, or the ray is not. Each result is computed in double and rounded once.
PLUMB_INLINE bool meets(const ShearedRay& ray, const Corners& corners, TriangleHit& hit) {
    const int x = ray.axis[0], y = ray.axis[1], z = ray.axis[2];
    const double az = corners.a[z] - ray.origin[2], bz = corners.b[z] - ray.origin[2],
                 cz = corners.c[z] - ray.origin[2];
    const double ax = (corners.a[x] - ray.origin[0]) - ray.shear_x * az,
                 ay = (corners.a[y] - ray.origin[1]) - ray.shear_y * az;
    const double bx = (corners.b[x] - ray.origin[0]) - ray.shear_x * bz,
                 by = (corners.b[y] - ray.origin[1]) - ray.shear_y * bz;
    const double cx = (corners.c[x] - ray.origin[0]) - ray.shear_x * cz,
                 cy = (corners.c[y] - ray.origin[1]) - ray.shear_y * cz;
    const double u = cx * by - cy * bx, v = ax * cy - ay * cx, w = bx * ay - by * ax;
    if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return false;
    const double sum = u + v + w;
    if (!(sum != 0)) return false;
    hit.t = float((u * az + v * bz + w * cz) * ray.scale / sum);
    hit.u = float(v / sum);
    hit.v = float(w / sum);
    return hit.t == hit.t;
}

// (b - a) x (c - a), each component rounded once to float.
struct FaceNormal {
    float x, y, z;
};
PLUMB_INLINE FaceNormal face_normal(const Corners& t) {
    const double bx = double(t.b[0]) - t.a[0], by = double(t.b[1]) - t.a[1], bz = double(t.b[2]) - t.a[2];
    const double cx = double(t.c[0]) - t.a[0], cy = double(t.c[1]) - t.a[1], cz = double(t.c[2]) - t.a[2];
    return {float(by * cz - bz * cy), float(bz * cx - bx * cz), float(bx * cy - by * cx)};
}

}  // namespace plumb::reference
