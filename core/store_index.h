// Stores an index of each lane: what number<F>::store does for numbers. Kernels include it.
#pragma once

#include "core/number.h"

namespace plumb {

template <class F>
PLUMB_INLINE void store_index(std::int32_t* p, index_t<F> at, index_t<F> value, mask_t<F> active) {
    using I = index_t<F>;
    constexpr int width = number<F>::width;
    const I on = select(active, I(-1), I(0));
    std::int32_t to[width], what[width], lanes[width];
    std::memcpy(to, &at, sizeof to), std::memcpy(what, &value, sizeof what), std::memcpy(lanes, &on, sizeof lanes);
    for (int k = 0; k < width; ++k)
        if (lanes[k]) p[to[k]] = what[k];
}

}  // namespace plumb
