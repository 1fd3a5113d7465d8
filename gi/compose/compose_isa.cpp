#include "gi/compose/compose_rows.h"
#include "gi/shade_rows.h"

namespace plumb::compose {

using F = PLUMB_ISA::Real;
using I = index_t<F>;

template <>
void Rows<Isa::PLUMB_ISA>::compose(const ComposeInputsView& in, int first, int last) {
    shade_rows(in.u.width, first, last, nullptr, in.radiance, 0.0f,
               [&](I px, I py, NoTap& tap) { return plumb::compose::compose<F>(in, px, py, tap); });
}

template <>
void Rows<Isa::PLUMB_ISA>::tonemap(const TonemapInputsView& in, int first, int last) {
    shade_rows(in.u.width, first, last, nullptr, in.display, 1.0f,
               [&](I px, I py, NoTap& tap) { return plumb::compose::tonemap<F>(in, px, py, tap); });
}

}  // namespace plumb::compose
