#include "gi/isr/cameras_rows.h"
#include "gi/shade_rows.h"

namespace plumb::isr {

namespace {

using F = PLUMB_ISA::Real;
using I = index_t<F>;

}  // namespace

template <>
void CameraRows<Isa::PLUMB_ISA>::unseen(const UnseenInputsView& in, int first, int last) {
    shade_rows(in.u.u.width, first, last, nullptr, in.unseen, 0.0f,
               [&](I px, I py, NoTap& tap) { return isr::unseen<F>(in, px, py, tap); });
}

template <>
void CameraRows<Isa::PLUMB_ISA>::gather_camera(const GatherCameraInputsView& in, int first, int last,
                                               const std::uint8_t* tiles) {
    shade_rows(in.u.u.width, first, last, tiles, in.gathered, 0.0f,
               [&](I px, I py, NoTap& tap) { return isr::gather_camera<F>(in, px, py, tap); });
}

}  // namespace plumb::isr
