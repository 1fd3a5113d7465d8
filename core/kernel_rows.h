// A kernel over rows of its domain: what a stage's loop is called by, and what kernel files define once per instruction
// set. Included by kernel files too, so it holds no container.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/isa_name.h"

namespace plumb {

// Which squares of 16 x 16 items are computed (raster/covered.h); the others keep what they hold. any null: all.
struct Tiles {
    const std::uint8_t* any = nullptr;  // [rows][across]
    int across = 0;

    const std::uint8_t* row(int y) const { return any ? any + std::ptrdiff_t(y >> 4) * across : nullptr; }
};

// The part of the block that says how wide and how high the domain is: the block, or Kernel::frame(view).
template <class Kernel, class View>
auto& frame_of(View& view) {
    if constexpr (requires { Kernel::frame(view); })
        return Kernel::frame(view);
    else
        return view.u;
}

// Rows [first, last) of the domain of Kernel. core/shade_rows.h defines run() for kernels that compute one item at a
// time; a stage with a loop of its own specialises it in its kernel file. `scratch`: Kernel::scratch() floats, aligned
// to 64 bytes, which belong to the band; null where the kernel asks for none.
template <class Kernel, Isa isa>
struct Rows {
    static void run(const typename Kernel::View& in, int first, int last, const Tiles& tiles, float* scratch);
};

// What all bands of a stage read, made before the first of them: rows [first, last) of Kernel::shared_rows(view), each for
// itself. Only where the kernel has shared_floats().
template <class Kernel, Isa isa>
struct SharedRows {
    static void run(const typename Kernel::View& in, int first, int last, float* shared);
};

}  // namespace plumb
