#include "gi/rsm/paths_rows.h"
#include "gi/shade_rows.h"

namespace plumb::rsm {

using F = PLUMB_ISA::Real;
using I = index_t<F>;

namespace {

template <class View>
void shade(const View& in, int first, int last, const std::uint8_t* tiles) {
    if (in.positions)
        shade_rows(in.u.width, first, last, tiles, in.irradiance, 0.0f,
                   [&](I px, I py, NoTap& tap) { return gather_paths<F, true>(in, px, py, tap); });
    else
        shade_rows(in.u.width, first, last, tiles, in.irradiance, 0.0f,
                   [&](I px, I py, NoTap& tap) { return gather_paths<F>(in, px, py, tap); });
}

}  // namespace

template <>
void PathsRows<Isa::PLUMB_ISA, float>::paths(const PathsInputsView<float>& in, int first, int last,
                                             const std::uint8_t* tiles) {
    shade(in, first, last, tiles);
}

template <>
void PathsRows<Isa::PLUMB_ISA, Half>::paths(const PathsInputsView<Half>& in, int first, int last,
                                            const std::uint8_t* tiles) {
    shade(in, first, last, tiles);
}

}  // namespace plumb::rsm
