// The loop that every kernel of one item shares: rows of the domain, a packet of lanes at a time. Only kernel files
// include it; an explicit instantiation a stage is all they hold:
//
//     template struct Rows<isr::Bounce, Isa::PLUMB_ISA>;
#pragma once

#include <type_traits>

#include "core/kernel_rows.h"
#include "core/tap.h"
#include "core/wide.h"

namespace plumb {

// Stores what a kernel computed for the items `at` of the domain, of which `active` exist.
template <class F>
PLUMB_INLINE void store_value(float* out, index_t<F> at, const vec4<F>& value, mask_t<F> active) {
    number<F>::store4(out, at, value, active);
}
template <class F>
PLUMB_INLINE void store_value(float* out, index_t<F> at, const F& value, mask_t<F> active) {
    number<F>::store(out, at, value, active);
}

// What each_packet() takes where every item is written.
struct AllItems {};

// Calls kernel(x, px, y, tap) for packets of the rows [first, last) of a domain `width` wide, x the packet's first
// column, and store(at, value, active). Lanes beyond the row repeat its last item and are not stored, nor are those that
// writes(px, y) leaves out; a packet of which none is written is not computed. Packets go down the columns of the band, so
// that a tile about as high as it is wide shares what it reads.
template <class F, class Kernel, class Store, class Writes = AllItems>
PLUMB_INLINE void each_packet(int width, int first, int last, const Tiles& tiles, Kernel kernel, Store store,
                              Writes writes = {}) {
    using N = number<F>;
    using I = index_t<F>;
    for (int x = 0; x < width; x += N::width) {
        const I px = min(N::iota(x), I(width - 1));
        for (int y = first; y < last; ++y) {
            const std::uint8_t* row = tiles.row(y);
            if (row && !row[x >> 4]) continue;
            mask_t<F> active = N::iota(x) < I(width);
            if constexpr (!std::is_same_v<Writes, AllItems>) {
                active = active & writes(px, y);
                if (!any(active)) continue;
            }
            NoTap tap;
            store(I(y * width) + px, kernel(x, px, y, tap), active);
        }
    }
}
// The same into the one output of a stage.
template <class F, class Kernel>
PLUMB_INLINE void shade_packets(int width, int first, int last, const Tiles& tiles, float* out, Kernel kernel) {
    each_packet<F>(width, first, last, tiles, kernel, [&](index_t<F> at, const auto& value, mask_t<F> active) {
        store_value<F>(out, at, value, active);
    });
}

template <class Kernel, Isa isa>
void Rows<Kernel, isa>::run(const typename Kernel::View& in, int first, int last, const Tiles& tiles, float*) {
    using F = PLUMB_ISA::Real;
    using I = index_t<F>;
    const auto kernel = [&](int, I px, int y, NoTap& tap) { return Kernel::template item<F>(in, px, I(y), tap); };
    const int width = frame_of<Kernel>(in).width;
    const auto store = [&](I at, const auto& value, mask_t<F> active) {
        if constexpr (requires { Kernel::out(in); })
            store_value<F>(Kernel::out(in), at, value, active);
        else
            Kernel::template store<F>(in, at, value, active);
    };
    if constexpr (requires(I i) { Kernel::template writes<F>(in, i, i); })
        each_packet<F>(width, first, last, tiles, kernel, store,
                       [&](I px, int y) { return Kernel::template writes<F>(in, px, I(y)); });
    else
        each_packet<F>(width, first, last, tiles, kernel, store);
}

}  // namespace plumb
