// Which texels a gather reads: those that a table names, counted from the projection of x. whole_texels.glsl and
// continuous_texels.glsl are the twins, one for each structure.
#pragma once

#include <type_traits>

#include "raster/project_kernel.h"

namespace plumb::rsm {

// An entry of a table: one a lane or, where a packet's lanes share the row, one for all of them.
template <class F, class Row>
PLUMB_INLINE index_t<F> entry(const std::int32_t* table, const Row& row) {
    if constexpr (std::is_same_v<Row, index_t<F>>)
        return number<F>::fetch(table, row);
    else
        return index_t<F>(table[row]);
}
template <class F, class Row>
PLUMB_INLINE F entry(const float* table, const Row& row) {
    if constexpr (std::is_same_v<Row, index_t<F>>)
        return number<F>::fetch(table, row);
    else
        return F(table[row]);
}

// differs: the theses compute every sample's position and round it. Here the projection alone is rounded and samples are
// whole texels away from it, so that which texels are read hardly depends on how a device rounds.
template <class F>
struct WholeTexels {
    using I = index_t<F>;
    ivec2<I> centre;

    template <class Tap>
    PLUMB_INLINE WholeTexels(const raster::Projection& map, const vec3<F>& x, Tap& tap)
        : centre(raster::project<F>(map, x, tap)) {
        tap("centre", centre, "texel of the projection");
    }

    // Where no sample can meet the map, as behind a face of a point light, there is nothing to sum. The lanes that are
    // near decide for themselves alone, so that no width of a packet changes a bit.
    PLUMB_INLINE mask_t<F> near(std::int32_t map_size, std::int32_t reach) const {
        const I range(map_size + 2 * reach);
        return in_range(centre.x + I(reach), range) & in_range(centre.y + I(reach), range);
    }

    // Texels from the border of a map on which projections are held (projection `clamped`): 0 where one is, in a border texel.
    PLUMB_INLINE F within(const raster::Projection& map) const {
        using N = number<F>;
        const F x = N::from_index(centre.x), y = N::from_index(centre.y), last(float(map.size - 1));
        return min(min(x, last - x), min(y, last - y));
    }

    // in.offsets: dx in the lower 16 bits, dy in the upper 16.
    template <class View, class Row, class Tap>
    PLUMB_INLINE ivec2<I> texel(const View& in, const Row& row, Tap&) const {
        const I offset = entry<F>(in.offsets, row);
        return {centre.x + ((offset << 16) >> 16), centre.y + (offset >> 16)};
    }
};

// As in the theses: the sample's own position is computed, and its texel is the one that it lies in.
template <class F>
struct ContinuousTexels {
    using I = index_t<F>;
    vec2<F> centre;

    template <class Tap>
    PLUMB_INLINE ContinuousTexels(const raster::Projection& map, const vec3<F>& x, Tap& tap)
        : centre(raster::projected<F>(map, x, tap)) {}

    // `reach` is a texel more than any offset: no rounding of a position moves a sample of what is not near to the map.
    PLUMB_INLINE mask_t<F> near(std::int32_t map_size, std::int32_t reach) const {
        const F low(float(-reach)), high(float(map_size + reach));
        return (centre.x >= low) & (centre.x < high) & (centre.y >= low) & (centre.y < high);
    }

    PLUMB_INLINE F within(const raster::Projection& map) const {
        const F low(map.low), high(map.high);
        return min(min(centre.x - low, high - centre.x), min(centre.y - low, high - centre.y));
    }

    // in.positions: dx, dy.
    template <class View, class Row, class Tap>
    PLUMB_INLINE ivec2<I> texel(const View& in, const Row& row, Tap& tap) const {
        using raster::chosen;
        const vec2<F> place{centre.x + entry<F>(in.positions, row + row),
                            centre.y + entry<F>(in.positions, row + row + Row(1))};
        tap("place", place, "the sample's position on the map, texels");
        return {chosen(place.x), chosen(place.y)};
    }
};

template <class F, bool continuous>
using TexelsOf = std::conditional_t<continuous, ContinuousTexels<F>, WholeTexels<F>>;

}  // namespace plumb::rsm
