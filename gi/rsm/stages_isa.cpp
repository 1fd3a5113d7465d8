#include "core/shade_rows.h"
#include "gi/rsm/paths_packets.h"

namespace plumb {

using namespace rsm;

template struct Rows<DiscKernel<false, float>, Isa::PLUMB_ISA>;
template struct Rows<DiscKernel<false, Half>, Isa::PLUMB_ISA>;
template struct Rows<DiscKernel<true, float>, Isa::PLUMB_ISA>;
template struct Rows<DiscKernel<true, Half>, Isa::PLUMB_ISA>;
template struct Rows<AllKernel, Isa::PLUMB_ISA>;

template <>
void Rows<PathsKernel<false, float>, Isa::PLUMB_ISA>::run(const PathsInputsView<float>& in, int first, int last,
                                                      const Tiles& tiles, float*) {
    shade_paths<PLUMB_ISA::Real, false>(in, first, last, tiles);
}
template <>
void Rows<PathsKernel<false, Half>, Isa::PLUMB_ISA>::run(const PathsInputsView<Half>& in, int first, int last,
                                                      const Tiles& tiles, float*) {
    shade_paths<PLUMB_ISA::Real, false>(in, first, last, tiles);
}
template <>
void Rows<PathsKernel<true, float>, Isa::PLUMB_ISA>::run(const PathsInputsView<float>& in, int first, int last,
                                                      const Tiles& tiles, float*) {
    shade_paths<PLUMB_ISA::Real, true>(in, first, last, tiles);
}
template <>
void Rows<PathsKernel<true, Half>, Isa::PLUMB_ISA>::run(const PathsInputsView<Half>& in, int first, int last,
                                                      const Tiles& tiles, float*) {
    shade_paths<PLUMB_ISA::Real, true>(in, first, last, tiles);
}

}  // namespace plumb
