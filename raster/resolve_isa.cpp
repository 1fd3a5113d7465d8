#include "core/tap.h"
#include "core/wide.h"
#include "raster/resolve_rows.h"

namespace plumb::raster {

namespace {

using F = PLUMB_ISA::Real;
using N = number<F>;
using I = index_t<F>;

// A packet of consecutive pixels of a row: which are covered, and by what. Lanes that see nothing, or lie beyond the
// row, read triangle 0 and are not written.
struct Packet {
    I pixel, triangle;
    vec2<F> barycentrics;
    mask_t<F> covered;
};
PLUMB_INLINE Packet packet(const std::int32_t* triangle, const float* barycentrics, int width, int x, int y) {
    const I column = min(N::iota(x), I(width - 1)), pixel = I(y) * I(width) + column;
    const I seen = N::fetch(triangle, pixel);
    return {pixel, max(seen, I(0)),
            {N::fetch(barycentrics, pixel * I(2)), N::fetch(barycentrics, pixel * I(2) + I(1))},
            mask_t<F>((seen >= I(0)) & (N::iota(x) < I(width)))};
}

}  // namespace

template <>
void ResolveRows<Isa::PLUMB_ISA>::gbuffer(const GBufferArgs& in, int first, int last) {
    NoTap tap;
    for (int y = first; y < last; ++y) {
        for (int x = 0; x < in.width; x += N::width) {
            const Packet p = packet(in.triangle, in.barycentrics, in.width, x, y);
            if (!any(p.covered)) continue;
            const GBufferPixel<F> out = raster::gbuffer<F>(in, p.triangle, p.barycentrics, tap);
            N::store4(in.position, p.pixel, out.position, p.covered);
            N::store4(in.normal, p.pixel, out.normal, p.covered);
            N::store4(in.albedo, p.pixel, out.albedo, p.covered);
            N::store4(in.emission, p.pixel, out.emission, p.covered);
        }
    }
}

template <>
void ResolveRows<Isa::PLUMB_ISA>::rsm(const RsmArgs& in, int first, int last) {
    NoTap tap;
    for (int y = first; y < last; ++y) {
        for (int x = 0; x < in.size; x += N::width) {
            const Packet p = packet(in.triangle, in.barycentrics, in.size, x, y);
            if (!any(p.covered)) continue;
            const RsmTexel<F> out = raster::rsm<F>(in, N::iota(x), I(y), p.triangle, p.barycentrics, tap);
            N::store4(in.position, p.pixel, out.position, p.covered);
            N::store4(in.normal, p.pixel, out.normal, p.covered);
            N::store4(in.flux, p.pixel, out.flux, p.covered);
        }
    }
}

}  // namespace plumb::raster
