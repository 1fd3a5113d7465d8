// Directions on octahedral tiles, mirrored by octahedral.glsl (Meyer et al. 2010; Cigolle et al. 2014, 3.1 and listing 1).
//
// A tile has side x side texels and a gutter of one texel around them: texel k of 0 .. side + 1 has its centre at k, and the
// map's square [-1, 1]^2 spans 1/2 .. side + 1/2. The pole +z lies in the middle, -z in all four corners.
#pragma once

#include "core/number.h"

namespace plumb::ddgi {

template <class F>
PLUMB_INLINE F sign_not_zero(F x) {
    return select(x < F(0.0f), F(-1.0f), F(1.0f));
}

// The lower half of the octahedron, folded over the edges of the square; and back: the fold is its own inverse.
template <class F>
PLUMB_INLINE vec2<F> folded(const vec2<F>& e) {
    return {(F(1.0f) - abs(e.y)) * sign_not_zero(e.x), (F(1.0f) - abs(e.x)) * sign_not_zero(e.y)};
}

// The point of [-1, 1]^2 of a direction of any length; of 0 the middle.
template <class F>
PLUMB_INLINE vec2<F> octahedral_of(const vec3<F>& d) {
    const F length = max(abs(d.x) + abs(d.y) + abs(d.z), F(1e-30f));
    const vec2<F> e{d.x / length, d.y / length};
    const vec2<F> f = folded(e);
    const mask_t<F> below = d.z < F(0.0f);
    return {select(below, f.x, e.x), select(below, f.y, e.y)};
}

// The unit direction of a point of [-1, 1]^2.
template <class F>
PLUMB_INLINE vec3<F> direction_of(const vec2<F>& e) {
    const F z = F(1.0f) - abs(e.x) - abs(e.y);
    const vec2<F> f = folded(e);
    const mask_t<F> below = z < F(0.0f);
    return normalize3<F>({select(below, f.x, e.x), select(below, f.y, e.y), z});
}

// Where a point of the square lies in its tile, texels; and the point of a texel's centre.
template <class F>
PLUMB_INLINE F place_in_tile(F e, int side) {
    const F half = F(0.5f * float(side));
    return e * half + (half + F(0.5f));
}
template <class F>
PLUMB_INLINE F centre_of_texel(index_t<F> texel, int side) {
    const F half = F(0.5f * float(side));
    return (number<F>::from_index(texel) - (half + F(0.5f))) / half;
}

// x / n for 0 <= x < 2^22 and n > 0: (x + 1/2) / n is farther from whole numbers than its rounding.
template <class F>
PLUMB_INLINE index_t<F> divided(index_t<F> x, int n) {
    return number<F>::truncate_to_index((number<F>::from_index(x) + F(0.5f)) / F(float(n)));
}

// The tile that a texel of the atlas belongs to, and its place in it.
template <class F>
struct InTile {
    ivec2<index_t<F>> tile, texel;  // texel: 0 and side + 1 are the gutter
};
template <class F>
PLUMB_INLINE InTile<F> in_tile(index_t<F> px, index_t<F> py, int side) {
    using I = index_t<F>;
    const I x = divided<F>(px, side + 2), y = divided<F>(py, side + 2);
    return {{x, y}, {px - x * I(side + 2), py - y * I(side + 2)}};
}

}  // namespace plumb::ddgi
