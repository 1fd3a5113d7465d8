#include "core/shade_rows.h"
#include "gi/filter/blur_kernel.h"
#include "gi/filter/reduce_kernel.h"
#include "gi/filter/upsample_kernel.h"

namespace plumb::filter {

namespace {

using F = PLUMB_ISA::Real;
using N = number<F>;
using I = index_t<F>;

// The pixels around (x + lane, y), from planes.
struct PlaneTexels {
    const BlurPlanes& planes;
    int x, y;
    bool plane;  // positions are read

    PLUMB_INLINE Texel<F> at(int dx, int dy) const {
        const float* p = planes.at(0, y + dy) + (x + dx);
        const int s = planes.stride;
        auto load = [&](int k) { return N::load(p + std::ptrdiff_t(k) * s); };
        Texel<F> t;
        t.irradiance = {load(BlurPlanes::red), load(BlurPlanes::green), load(BlurPlanes::blue)};
        t.depth = load(BlurPlanes::depth);
        t.normal = {load(BlurPlanes::normal_x), load(BlurPlanes::normal_y), load(BlurPlanes::normal_z)};
        t.position = {load(BlurPlanes::position_x), load(BlurPlanes::position_y), load(BlurPlanes::position_z)};
        return t;
    }
};

void clear_rows(const BlurPlanes& planes, int y) {
    float* p = planes.at(0, y) - BlurPlanes::padding;
    for (int i = 0; i < BlurPlanes::count * planes.stride; ++i) p[i] = 0;
}

PLUMB_INLINE void save(const BlurPlanes& planes, int plane, int x, int y, const vec4<F>& value, mask_t<F> on, int n) {
    for (int c = 0; c < n; ++c) N::save(planes.at(plane + c, y) + x, select(on, value[c], F(0.0f)));
}

void take_apart(const BlurInputsView& in, const BlurPlanes& planes, int y) {
    clear_rows(planes, y);
    if (y < 0 || y >= in.u.height) return;
    const int width = in.u.width;
    for (int x = 0; x < width; x += N::width) {
        const I i = I(y * width) + min(N::iota(x), I(width - 1));
        const mask_t<F> on = N::iota(x) < I(width);
        save(planes, BlurPlanes::red, x, y, N::fetch4(in.irradiance, i), on, 4);
        save(planes, BlurPlanes::normal_x, x, y, N::fetch4(in.normal, i), on, 3);
        save(planes, BlurPlanes::position_x, x, y, N::fetch4(in.position, i), on, 3);
    }
}

}  // namespace

}  // namespace plumb::filter

namespace plumb {

using namespace filter;

template struct Rows<ReduceKernel, Isa::PLUMB_ISA>;
template struct Rows<UpsampleKernel, Isa::PLUMB_ISA>;

template <>
void Rows<BlurKernel, Isa::PLUMB_ISA>::run(const BlurInputsView& in, int first, int last, const Tiles& tiles,
                                           float* scratch) {
    const BlurPlanes planes{scratch, BlurPlanes::stride_of(in.u.width), first - in.u.radius_y};
    for (int y = first - in.u.radius_y; y < last + in.u.radius_y; ++y) take_apart(in, planes, y);
    const bool plane = in.u.similarity == int(Similarity::plane);
    shade_packets<F>(in.u.width, first, last, tiles, in.blurred, [&](int x, I, int y, NoTap& tap) {
        return filter::blur<F>(in.u, in.spatial, PlaneTexels{planes, x, y, plane}, tap);
    });
}

}  // namespace plumb
