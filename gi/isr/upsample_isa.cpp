// isr.upsample over rows: from planes (upsample_kernel.h).
#include "core/shade_rows.h"
#include "gi/isr/upsample_kernel.h"

namespace plumb::isr {

namespace {

using F = PLUMB_ISA::Real;
using N = number<F>;
using I = index_t<F>;

// The 2 x 2 coarse pixels around (x + lane, y), from planes.
struct PlaneTexels {
    const UpsamplePlanes& planes;
    int x, above, below_row;

    PLUMB_INLINE UpsampleTexel<F> at(bool right, bool below) const {
        const float* p = planes.at(0, below ? below_row : above) + (right ? x + 2 : x);
        const int s = planes.stride;
        auto load = [&](int k) { return N::load(p + std::ptrdiff_t(k) * s); };
        return {{load(UpsamplePlanes::red), load(UpsamplePlanes::green), load(UpsamplePlanes::blue)},
                load(UpsamplePlanes::open),
                load(UpsamplePlanes::covered),
                load(UpsamplePlanes::depth)};
    }
};

// Coarse row y, each pixel once for every full pixel that it is before.
PLUMB_INLINE void take_apart(const UpsampleInputsView& in, const UpsamplePlanes& planes, int y) {
    const int coarse_width = in.u.coarse_width;
    for (int x = 0; x < in.u.width + 2; x += N::width) {
        const I before = min(coarse_before(N::iota(x)), I(coarse_width - 1));
        const UpsampleTexel<F> t = coarse_texel<F>(in, I(y * coarse_width) + before);
        auto save = [&](int plane, const F& value) { N::save(planes.at(plane, y) + x, value); };
        save(UpsamplePlanes::red, t.irradiance.x), save(UpsamplePlanes::green, t.irradiance.y);
        save(UpsamplePlanes::blue, t.irradiance.z), save(UpsamplePlanes::open, t.accessibility);
        save(UpsamplePlanes::covered, t.covered), save(UpsamplePlanes::depth, t.depth);
    }
}

template <bool bilateral, bool published>
PLUMB_INLINE void upsample_rows(const UpsampleInputsView& in, int first, int last, float* scratch, const Tiles& tiles) {
    const int coarse_height = in.u.coarse_height;
    const UpsamplePlanes planes{scratch, UpsamplePlanes::stride_of(in.u.width), coarse_before(first)};
    for (int y = planes.first_row; y <= coarse_after(last - 1, coarse_height); ++y) take_apart(in, planes, y);
    shade_packets<F>(in.u.width, first, last, tiles, in.upsampled, [&](int x, I px, int y, NoTap& tap) {
        const PlaneTexels texels{planes, x, coarse_before(y), coarse_after(y, coarse_height)};
        return upsample_by<F, bilateral, published>(in, texels, px, I(y), tap);
    });
}

}  // namespace

}  // namespace plumb::isr

namespace plumb {

using namespace isr;

template <>
void Rows<UpsampleKernel, Isa::PLUMB_ISA>::run(const UpsampleInputsView& in, int first, int last, const Tiles& tiles,
                                               float* scratch) {
    const bool published = in.u.published != 0;
    if (in.u.bilateral == 0)
        return published ? upsample_rows<false, true>(in, first, last, scratch, tiles)
                         : upsample_rows<false, false>(in, first, last, scratch, tiles);
    published ? upsample_rows<true, true>(in, first, last, scratch, tiles)
              : upsample_rows<true, false>(in, first, last, scratch, tiles);
}

}  // namespace plumb
