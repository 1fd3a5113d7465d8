#include "gi/direct/direct_rows.h"
#include "gi/shade_rows.h"

namespace plumb::direct {

using F = PLUMB_ISA::Real;
using I = index_t<F>;

template <>
void Rows<Isa::PLUMB_ISA>::shadow(const ShadowInputsView& in, int first, int last, const std::uint8_t* tiles) {
    if (in.u.face < 0) {
        shade_rows_scalar(in.u.width, first, last, tiles, in.visibility,
                          [&](I px, I py, NoTap& tap) { return plumb::direct::shadow<F>(in, px, py, tap); });
        return;
    }
    shade_rows_scalar(in.u.width, first, last, tiles, in.visibility, [&](I px, I py, NoTap& tap) {
        const I pixel = py * I(in.u.width) + px;
        const F before = number<F>::fetch(in.visibility, pixel);
        const mask_t<F> served = serves<F>(in.u, xyz<F>(number<F>::fetch4(in.position, pixel)));
        return any(served) ? select(served, plumb::direct::shadow<F>(in, px, py, tap), before) : before;
    });
}

template <>
void Rows<Isa::PLUMB_ISA>::direct(const DirectInputsView& in, int first, int last, const std::uint8_t* tiles) {
    shade_rows(in.u.width, first, last, tiles, in.irradiance, 0.0f,
               [&](I px, I py, NoTap& tap) { return plumb::direct::direct<F>(in, px, py, tap); });
}

template <>
void Rows<Isa::PLUMB_ISA>::log_blur(const LogBlurInputsView& in, int first, int last) {
    shade_rows(in.u.width, first, last, nullptr, in.blurred, 0.0f,
               [&](I px, I py, NoTap& tap) { return plumb::direct::log_blur<F>(in, px, py, tap); });
}

}  // namespace plumb::direct
