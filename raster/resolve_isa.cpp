#include "core/tap.h"
#include "core/wide.h"
#include "raster/resolve_rows.h"
#include "raster/texel_rows.h"

namespace plumb::raster {

namespace {

using F = PLUMB_ISA::Real;
using N = number<F>;
using I = index_t<F>;

// A packet of consecutive pixels of a row: which are covered, and by what. Lanes that see nothing, or lie beyond the
// row, read triangle 0.
struct Packet {
    I x, triangle;
    vec2<F> barycentrics;
    mask_t<F> covered;
    int count;  // lanes within the row
};
PLUMB_INLINE Packet packet(const std::int32_t* triangle, const float* barycentrics, int width, int x, int y) {
    const std::ptrdiff_t first = std::ptrdiff_t(y) * width + x;
    if (x + N::width <= width) {
        const I seen = PLUMB_ISA::load_row<F>(triangle + first);
        return {N::iota(x), max(seen, I(0)), PLUMB_ISA::load_pairs<F>(barycentrics + 2 * first),
                mask_t<F>(seen >= I(0)), N::width};
    }
    const I pixel = min(N::iota(x), I(width - 1)) + I(y) * I(width);
    const I seen = N::fetch(triangle, pixel);
    return {N::iota(x), max(seen, I(0)),
            {N::fetch(barycentrics, pixel * I(2)), N::fetch(barycentrics, pixel * I(2) + I(1))},
            mask_t<F>((seen >= I(0)) & (N::iota(x) < I(width))), width - x};
}

// Writes a packet's texels where there is a target; 0 where nothing is seen.
PLUMB_INLINE void put(float* target, std::ptrdiff_t first, const vec4<F>& value, const Packet& p,
                      bool past_caches = false) {
    if (!target) return;
    const F zero(0.0f);
    const vec4<F> v{select(p.covered, value.x, zero), select(p.covered, value.y, zero),
                    select(p.covered, value.z, zero), select(p.covered, value.w, zero)};
    PLUMB_ISA::store_row4<F>(target + 4 * first, v, p.count, past_caches);
}

// Calls visit(triangle) for each run of one triangle that begins in the packet of a row at pixel x > 0. Most packets
// see one triangle: they are not searched.
template <class Visit>
PLUMB_INLINE void for_runs(const std::int32_t* row, int x, int width, const Visit& visit) {
    if (N::width == 1 || x + N::width > width) return;
    const bool mixed = any(!(PLUMB_ISA::load_row<F>(row + x) == I(row[x])));
    for (int i = x; i < (mixed ? x + N::width : x + 1); ++i)
        if (row[i] >= 0 && row[i] != row[i - 1]) visit(std::ptrdiff_t(row[i]));
}

// Asks for what the next packets of a row will read: of the second where its triangles' corners and materials are
// listed, of the first, for which these have come by now, the vertices.
PLUMB_INLINE void prefetch(const SurfaceArgs& in, const std::int32_t* row, int x, int width) {
    auto ask = [](const auto* p) { _mm_prefetch(reinterpret_cast<const char*>(p), _MM_HINT_T0); };
    for_runs(row, x + 2 * N::width, width,
             [&](std::ptrdiff_t t) { ask(in.triangles + 3 * t), ask(in.material + t); });
    for_runs(row, x + N::width, width, [&](std::ptrdiff_t t) {
        for (int k = 0; k < 3; ++k) ask(in.vertices + 8 * std::ptrdiff_t(in.triangles[3 * t + k]));
    });
}

// From so many pixels on the targets of a frame are larger than a core's cache: to read them into it before they are
// overwritten would be waste.
constexpr std::ptrdiff_t many_pixels = 1 << 18;

// The branches that no target asks for fall away when this is compiled: with them textures, and normal maps.
template <bool with_colour, bool with_normal>
void gbuffer_rows(const GBufferArgs& in, int first, int last) {
    NoTap tap;
    const vec4<F> nothing(F(0.0f), F(0.0f), F(0.0f), F(0.0f));
    const bool past_caches = std::ptrdiff_t(in.width) * in.height >= many_pixels;
    for (int y = first; y < last; ++y) {
        for (int x = 0; x < in.width; x += N::width) {
            prefetch(in.surfaces, in.triangle + std::ptrdiff_t(y) * in.width, x, in.width);
            const Packet p = packet(in.triangle, in.barycentrics, in.width, x, y);
            const std::ptrdiff_t at = std::ptrdiff_t(y) * in.width + x;
            GBufferPixel<F> out{nothing, nothing, nothing, nothing};
            if (any(p.covered))
                out = stored<F>(in, raster::gbuffer<F>(in, p.triangle, p.barycentrics, tap), p.x, I(y));
            put(in.position, at, out.position, p, past_caches);
            if (with_normal) put(in.normal, at, out.normal, p, past_caches);
            if (with_colour) put(in.albedo, at, out.albedo, p, past_caches);
            if (with_colour) put(in.emission, at, out.emission, p, past_caches);
        }
    }
    if (past_caches) _mm_sfence();
}

}  // namespace

template <>
void ResolveRows<Isa::PLUMB_ISA>::gbuffer(const GBufferArgs& in, int first, int last) {
    const bool colour = in.albedo || in.emission;
    if (colour && in.normal) return gbuffer_rows<true, true>(in, first, last);
    if (colour) return gbuffer_rows<true, false>(in, first, last);
    if (in.normal) return gbuffer_rows<false, true>(in, first, last);
    if (in.position) return gbuffer_rows<false, false>(in, first, last);
}

template <>
void ResolveRows<Isa::PLUMB_ISA>::rsm(const RsmArgs& in, int first, int last, const RsmStore& store) {
    NoTap tap;
    const vec4<F> nothing(F(0.0f), F(0.0f), F(0.0f), F(0.0f));
    for (int y = first; y < last; ++y) {
        for (int x = 0; x < in.size; x += N::width) {
            const Packet p = packet(in.triangle, in.barycentrics, in.size, x, y);
            const std::ptrdiff_t at = std::ptrdiff_t(y) * in.size + x;
            RsmTexel<F> out{nothing, nothing, nothing};
            if (any(p.covered))
                out = stored<F>(store, raster::rsm<F>(in, p.x, I(y), p.triangle, p.barycentrics, tap));
            put(in.position, at, out.position, p);
            put(in.normal, at, out.normal, p);
            put(in.flux, at, out.flux, p);
        }
    }
}

}  // namespace plumb::raster
