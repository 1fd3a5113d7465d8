#include "gi/rsm/gather_rows.h"
#include "gi/shade_rows.h"

namespace plumb::rsm {

using F = PLUMB_ISA::Real;
using I = index_t<F>;

namespace {

template <class View>
void shade(const View& in, int first, int last, const std::uint8_t* tiles) {
    if (in.positions)
        shade_rows(in.u.width, first, last, tiles, in.irradiance, 0.0f,
                   [&](I px, I py, NoTap& tap) { return gather_disc<F, true>(in, px, py, tap); });
    else
        shade_rows(in.u.width, first, last, tiles, in.irradiance, 0.0f,
                   [&](I px, I py, NoTap& tap) { return gather_disc<F>(in, px, py, tap); });
}

}  // namespace

template <>
void GatherRows<Isa::PLUMB_ISA, float>::disc(const GatherInputsView<float>& in, int first, int last,
                                             const std::uint8_t* tiles) {
    shade(in, first, last, tiles);
}

template <>
void GatherRows<Isa::PLUMB_ISA, Half>::disc(const GatherInputsView<Half>& in, int first, int last,
                                            const std::uint8_t* tiles) {
    shade(in, first, last, tiles);
}

template <>
void GatherRows<Isa::PLUMB_ISA, float>::all(const GatherInputsView<float>& in, int first, int last,
                                            const std::uint8_t* tiles) {
    shade_rows(in.u.width, first, last, tiles, in.irradiance, 0.0f,
               [&](I px, I py, NoTap& tap) { return gather_all<F>(in, px, py, tap); });
}

}  // namespace plumb::rsm
