// The spatial kernel of probes (IPR 3.1.2.3, 3.2.2.1), mirrored by weight.glsl: how much a probe counts at a distance.
#pragma once

#include "core/number.h"

namespace plumb::probes {

// w(t) = 2 t^3 - 3 t^2 + 1 for t in [0, 1], as (1 - t)^2 (1 + 2 t): the same polynomial, never negative, without
// cancellation near 1.
template <class F>
PLUMB_INLINE F spatial_weight(F t) {
    const F s = F(1.0f) - t;
    return s * s * (F(1.0f) + (t + t));
}

// |a - b|^2
template <class F>
PLUMB_INLINE F distance2(const vec3<F>& a, const vec3<F>& b) {
    const F x = a.x - b.x, y = a.y - b.y, z = a.z - b.z;
    return x * x + y * y + z * z;
}

// The same of one probe for all lanes.
template <class F>
PLUMB_INLINE vec3<F> position_of(const float* positions, int i) {
    const float* p = positions + 4 * std::ptrdiff_t(i);
    return {F(p[0]), F(p[1]), F(p[2])};
}

}  // namespace plumb::probes
