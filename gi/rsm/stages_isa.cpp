#include "core/shade_rows.h"
#include "gi/rsm/rotation_packets.h"

namespace plumb {

using namespace rsm;

template struct Rows<AllKernel, Isa::PLUMB_ISA>;

#define PLUMB_BY_ROTATION(...)                                                                                        \
    template <>                                                                                                       \
    void Rows<__VA_ARGS__, Isa::PLUMB_ISA>::run(const __VA_ARGS__::View& in, int first, int last, const Tiles& tiles, \
                                                float*) {                                                             \
        shade_by_rotation<PLUMB_ISA::Real, __VA_ARGS__>(in, first, last, tiles);                                      \
    }

PLUMB_BY_ROTATION(DiscKernel<false, float>)
PLUMB_BY_ROTATION(DiscKernel<false, Half>)
PLUMB_BY_ROTATION(DiscKernel<true, float>)
PLUMB_BY_ROTATION(DiscKernel<true, Half>)
PLUMB_BY_ROTATION(PathsKernel<false, float>)
PLUMB_BY_ROTATION(PathsKernel<false, Half>)
PLUMB_BY_ROTATION(PathsKernel<true, float>)
PLUMB_BY_ROTATION(PathsKernel<true, Half>)

}  // namespace plumb
