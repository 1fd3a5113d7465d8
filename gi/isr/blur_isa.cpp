// isr.blur over rows: from planes (blur_kernel.h).
#include "core/shade_rows.h"
#include "gi/isr/blur_kernel.h"

namespace plumb::isr {

namespace {

using F = PLUMB_ISA::Real;
using N = number<F>;
using I = index_t<F>;

// The pixels before and after (x + lane, y), from planes.
struct PlaneTexels {
    const BlurPlanes& planes;
    int x, y;
    bool vertical;

    PLUMB_INLINE BlurTexel<F> at(int d) const {
        const float* p = planes.at(0, vertical ? y + d : y) + (vertical ? x : x + d);
        const int s = planes.stride;
        auto load = [&](int k) { return N::load(p + std::ptrdiff_t(k) * s); };
        return {{load(BlurPlanes::red), load(BlurPlanes::green), load(BlurPlanes::blue)},
                load(BlurPlanes::open),
                load(BlurPlanes::covered),
                {load(BlurPlanes::normal_x), load(BlurPlanes::normal_y), load(BlurPlanes::normal_z)},
                load(BlurPlanes::depth)};
    }
};

// Row y of the images, and what lies within the radius before and after it.
template <BlurKind kind>
PLUMB_INLINE void take_apart(const BlurInputsView& in, const BlurPlanes& planes, int y) {
    const int width = in.u.width, before = in.u.vertical != 0 ? 0 : BlurPlanes::padding;
    for (int x = -before; x < ((width + 15) & ~15) + before; x += N::width) {
        const BlurTexel<F> t = BlurImageTexels<F>{in, N::iota(x), I(y)}.at(0);
        auto save = [&](int plane, const F& value) { N::save(planes.at(plane, y) + x, value); };
        save(BlurPlanes::red, t.irradiance.x), save(BlurPlanes::green, t.irradiance.y);
        save(BlurPlanes::blue, t.irradiance.z), save(BlurPlanes::open, t.accessibility);
        save(BlurPlanes::covered, t.covered);
        if (kind != BlurKind::edge_aware) continue;
        save(BlurPlanes::normal_x, t.normal.x), save(BlurPlanes::normal_y, t.normal.y);
        save(BlurPlanes::normal_z, t.normal.z), save(BlurPlanes::depth, t.depth);
    }
}

template <BlurKind kind>
PLUMB_INLINE void blur_rows(const BlurInputsView& in, int first, int last, float* scratch, const Tiles& tiles) {
    const int halo = BlurPlanes::halo(in.u);
    const BlurPlanes planes{scratch, BlurPlanes::stride_of(in.u.width), first - halo};
    for (int y = first - halo; y < last + halo; ++y) take_apart<kind>(in, planes, y);
    shade_packets<F>(in.u.width, first, last, tiles, in.blurred, [&](int x, I px, int y, NoTap& tap) {
        return blur_by<F, kind>(in.u, in.spatial, px, I(y), PlaneTexels{planes, x, y, in.u.vertical != 0}, tap);
    });
}

}  // namespace

}  // namespace plumb::isr

namespace plumb {

using namespace isr;

template <>
void Rows<BlurKernel, Isa::PLUMB_ISA>::run(const BlurInputsView& in, int first, int last, const Tiles& tiles,
                                           float* scratch) {
    if (in.u.kind == int(BlurKind::gaussian)) return blur_rows<BlurKind::gaussian>(in, first, last, scratch, tiles);
    if (in.u.kind == int(BlurKind::edge_aware)) return blur_rows<BlurKind::edge_aware>(in, first, last, scratch, tiles);
    blur_rows<BlurKind::published>(in, first, last, scratch, tiles);
}

}  // namespace plumb
