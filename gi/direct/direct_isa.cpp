#include "gi/direct/direct_rows.h"
#include "gi/shade_rows.h"

namespace plumb::direct {

using F = PLUMB_ISA::Real;
using I = index_t<F>;

template <>
void Rows<Isa::PLUMB_ISA>::shadow(const ShadowInputsView& in, int first, int last) {
    shade_rows_scalar(in.u.width, first, last, in.visibility,
                      [&](I px, I py, NoTap& tap) { return plumb::direct::shadow<F>(in, px, py, tap); });
}

template <>
void Rows<Isa::PLUMB_ISA>::direct(const DirectInputsView& in, int first, int last) {
    shade_rows(in.u.width, first, last, in.irradiance, 0.0f,
               [&](I px, I py, NoTap& tap) { return plumb::direct::direct<F>(in, px, py, tap); });
}

}  // namespace plumb::direct
