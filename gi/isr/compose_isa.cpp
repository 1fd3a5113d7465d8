#include "gi/isr/compose_rows.h"
#include "gi/shade_rows.h"

namespace plumb::isr {

using F = PLUMB_ISA::Real;
using I = index_t<F>;

template <>
void ComposeRows<Isa::PLUMB_ISA>::compose(const ComposeInputsView& in, int first, int last) {
    shade_rows(in.u.width, first, last, nullptr, in.radiance, 0.0f,
               [&](I px, I py, NoTap& tap) { return isr::compose<F>(in, px, py, tap); });
}

}  // namespace plumb::isr
