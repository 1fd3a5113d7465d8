// Where points fall in the image of a view, a camera's or a light's, and what is seen there: mirrored by
// view.glsl; and which rotation a pixel has.
//
// Points are given from the view's anchor, its eye as a float: far from the origin a difference of positions keeps digits
// that their sum with a translation loses.
#pragma once

#include "core/number.h"
#include "raster/project_kernel.h"

namespace plumb::screen {

inline constexpr int rotations_a_side = 4, rotation_count = 16;

// Which of the rotations that pixels of 4 x 4 share out is this one's.
template <class F>
PLUMB_INLINE index_t<F> rotation_of(index_t<F> px, index_t<F> py) {
    using I = index_t<F>;
    const I last(rotations_a_side - 1);
    return (px & last) + (py & last) * I(rotations_a_side);
}

// A member of the twins' uniform blocks (std140).
struct SeenFrom {
    float anchor[4];      // xyz world, m
    float forward[4];     // linear depth = forward . (v, 1), v from the anchor
    float to_x[4];        // texel x = to_x . (v, 1) / depth; of parallel rays it is not divided
    float to_y[4];
    std::int32_t width, height;  // texels
    float least_depth;    // m, above 0: what is nearer, or behind the eye, is not seen; of parallel rays not asked
    float perspective;    // 1, or 0: parallel rays
};
static_assert(sizeof(SeenFrom) == 80);

template <class F>
PLUMB_INLINE F row_of(const float* m, const vec3<F>& v) {
    return F(m[0]) * v.x + F(m[1]) * v.y + F(m[2]) * v.z + F(m[3]);
}

// A point in the view.
template <class F>
struct Place {
    ivec2<index_t<F>> texel;
    F depth;           // m
    mask_t<F> inside;  // whether the image has that texel, and the point lies before the eye
};

template <class F, class Tap>
PLUMB_INLINE Place<F> place_of(const SeenFrom& view, const vec3<F>& v, Tap& tap) {
    using I = index_t<F>;
    const F depth = row_of(view.forward, v), least(view.least_depth);
    const bool perspective = view.perspective > 0.0f;
    const F divisor = perspective ? max(depth, least) : F(1.0f);
    // Far outside is far enough: an index must not overflow.
    const F low(-65536.0f), high(65536.0f);
    const F x = clamp(row_of(view.to_x, v) / divisor, low, high), y = clamp(row_of(view.to_y, v) / divisor, low, high);
    tap("depth", depth, "linear, of the view, m");
    const ivec2<I> texel{raster::chosen(x), raster::chosen(y)};
    tap("texel", texel, "of the view");
    mask_t<F> inside = in_range(texel.x, I(view.width)) & in_range(texel.y, I(view.height));
    if (perspective) inside = inside & (depth >= least);
    tap("inside", inside, "1 if the view has that texel, and the point lies before its eye");
    return {texel, depth, inside};
}

}  // namespace plumb::screen
