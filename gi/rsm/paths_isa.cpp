#include "gi/rsm/paths_packets.h"
#include "gi/rsm/paths_rows.h"

namespace plumb::rsm {

namespace {

template <class View>
void shade(const View& in, int first, int last, const std::uint8_t* tiles) {
    using F = PLUMB_ISA::Real;
    if (in.positions)
        shade_paths<F, true>(in, first, last, tiles);
    else
        shade_paths<F, false>(in, first, last, tiles);
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
