// Which pixel, and of which picture, an item of a sheet (sheet.h) is.
#pragma once

#include "core/number.h"

namespace plumb::screen {

// How often `size` fits into what is below 2^23: the quotient is never nearer to a whole number than 1 / (2 size), which is
// more than it is rounded by.
template <class F>
PLUMB_INLINE index_t<F> times_in(index_t<F> at, std::int32_t size) {
    using N = number<F>;
    return N::truncate_to_index((N::from_index(at) + F(0.5f)) / F(float(size)));
}

// The pixel's index in its picture; of one picture alone, rows = 0, the item's.
template <class F>
PLUMB_INLINE index_t<F> pixel_in_sheet(index_t<F> px, index_t<F> py, std::int32_t columns, std::int32_t rows, std::int32_t width) {
    using I = index_t<F>;
    if (rows == 0) return py * I(width) + px;
    const I x = px - times_in<F>(px, columns) * I(columns), y = py - times_in<F>(py, rows) * I(rows);
    return y * I(columns) + x;
}

}  // namespace plumb::screen
