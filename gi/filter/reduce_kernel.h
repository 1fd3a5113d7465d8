// One pixel of every 2 x 2: the algorithm that reduce.comp mirrors line by line. It is what nearest sampling reads at the
// centre of a pixel of half the size, which lies on the corner of four: the lower right one.
//
// A pixel is picked, not a mean taken: the mean of two surfaces' positions lies on neither.
#pragma once

#include "core/number.h"

namespace plumb::filter {

// The twin's uniform block (std140).
struct ReduceUniforms {
    std::int32_t width, height;            // of the half-size image
    std::int32_t full_width, full_height;
};
static_assert(sizeof(ReduceUniforms) == 16);

struct ReduceInputsView {
    ReduceUniforms u;
    const float* image;  // [full_height][full_width] rgba32f
    float* reduced;      // out: [height][width] rgba32f
};

template <class F, class Tap>
PLUMB_INLINE vec4<F> reduce(const ReduceInputsView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using I = index_t<F>;
    const ReduceUniforms& u = in.u;
    const I x = min(px + px + I(1), I(u.full_width - 1)), y = min(py + py + I(1), I(u.full_height - 1));
    tap("picked", ivec2<I>{x, y}, "(2 x + 1, 2 y + 1), within the image");
    const vec4<F> value = number<F>::fetch4(in.image, y * I(u.full_width) + x);
    tap("value", xyz<F>(value), "its first three components");
    return value;
}

struct ReduceKernel {
    using View = ReduceInputsView;
    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return reduce<F>(in, px, py, tap);
    }
    static float* out(const View& in) { return in.reduced; }
};

}  // namespace plumb::filter
