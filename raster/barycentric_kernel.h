// Where in a triangle a point lies that a G-buffer has rounded; barycentric.glsl is the twin.
//
// p = A + b e1 + c e2, e1 = B - A, e2 = C - A, with b and c of least squares,
//
//     b = ((d x e2) . n) / n^2,  c = ((e1 x d) . n) / n^2        d = p - A, n = e1 x e2
//
// which is the same to rounding as what the rasterizer has interpolated by. By dot products alone, as the normal equations have
// it, slivers lose twice as many digits.
#pragma once

#include "raster/surface_kernel.h"

namespace plumb::raster {

template <class F>
struct Barycentrics {
    F area;     // n^2: the triangle's area twice, squared, m4
    vec2<F> l;  // of B, 0..1; of C, 0..1 - l.x; both 0 of a triangle without area
};

// d = p - A.
template <class F>
PLUMB_INLINE Barycentrics<F> barycentrics_of(const vec3<F>& d, const vec3<F>& e1, const vec3<F>& e2) {
    const vec3<F> n = cross3(e1, e2);
    const F area = dot3(n, n);
    const F scale = F(1.0f) / select(area > F(0.0f), area, F(1.0f));
    const F b = max(F(0.0f), min(dot3(cross3(d, e2), n) * scale, F(1.0f)));
    const F c = max(F(0.0f), min(dot3(cross3(e1, d), n) * scale, F(1.0f) - b));
    return {area, {b, c}};
}

}  // namespace plumb::raster
