#include "core/tap.h"
#include "core/wide.h"
#include "raster/covered.h"
#include "raster/blocks.h"
#include "raster/resolve_tiles.h"
#include "raster/texel_rows.h"

namespace plumb::raster {

namespace {

using namespace PLUMB_ISA;
using F = PLUMB_ISA::Real;
using N = number<F>;
using I = index_t<F>;
using M = mask_t<F>;

// A block of a tile: which pixels are covered, and by what. Lanes that see nothing have the triangle of one that does,
// so that a block with one triangle is known as such.
struct Block {
    I x, y, triangle;  // pixel of the frame
    vec2<F> barycentrics;
    M covered;
    glm::ivec2 first;
    std::ptrdiff_t pixel;  // the first one's place in the frame
    glm::ivec2 count;      // columns and rows within the frame
};
PLUMB_INLINE Block block(const TilePixels& in, std::ptrdiff_t at, int width, int x, int y) {
    const I seen = load_lanes(in.triangle + at);
    const M covered = seen >= I(0);
    const unsigned lanes_covered = lane_bits(covered);
    const I some(lanes_covered ? in.triangle[at + __builtin_ctz(lanes_covered)] : 0);
    return {I(x) + lane_columns(), I(y) + lane_rows(), select(covered, seen, some),
            {load_lanes(in.l1 + at), load_lanes(in.l2 + at)}, covered, {x, y}, std::ptrdiff_t(y) * width + x,
            in.end - glm::ivec2(x, y)};
}

// Calls visit(block, its place in the tile) for each block of a tile.
template <class Visit>
PLUMB_INLINE void for_blocks(const TilePixels& in, int width, const Visit& visit) {
    for (int y = in.origin.y; y < in.end.y; y += block_height)
        for (int x = in.origin.x; x < in.end.x; x += block_width) {
            const std::ptrdiff_t at = block_at(in.side, x - in.origin.x, y - in.origin.y);
            visit(block(in, at, width, x, y), at);
        }
}

// Writes a block's texels where there is a target; 0 where nothing is seen.
PLUMB_INLINE void put(float* target, int width, const vec4<F>& value, const Block& b, bool past_caches = false) {
    if (!target) return;
    const F zero(0.0f);
    const vec4<F> v{select(b.covered, value.x, zero), select(b.covered, value.y, zero),
                    select(b.covered, value.z, zero), select(b.covered, value.w, zero)};
    store_texels<block_width, F>(target + 4 * b.pixel, 4 * std::ptrdiff_t(width), v, b.count, past_caches);
}

void put_ids(const GBufferArgs& in, const Block& b, const std::int32_t* triangle) {
    for (int row = 0; row < block_height && row < b.count.y; ++row)
        for (int column = 0; column < block_width && column < b.count.x; ++column) {
            const std::int32_t t = triangle[row * block_width + column];
            std::int32_t* id = in.id + 2 * (b.pixel + std::ptrdiff_t(row) * in.width + column);
            id[0] = t < 0 ? -1 : in.object[t], id[1] = t;
        }
}

// Asks for what the next blocks of a tile will read: of the second where its triangles' corners and materials are
// listed, of the first, for which these have come by now, the vertices. Blocks follow one another in memory; those
// beyond the frame see nothing.
PLUMB_INLINE void prefetch(const SurfaceArgs& in, const TilePixels& seen, std::ptrdiff_t at) {
    auto ask = [](const auto* p) { _mm_prefetch(reinterpret_cast<const char*>(p), _MM_HINT_T0); };
    auto ahead = [&](int blocks, const auto& visit) {
        const std::ptrdiff_t next = at + blocks * N::width;
        if (N::width == 1 || next >= std::ptrdiff_t(seen.side) * seen.side) return;
        const I triangle = load_lanes(seen.triangle + next);
        for_distinct(triangle, seen.triangle + next, lane_bits(triangle >= I(0)),
                     [&](std::ptrdiff_t t, M) { visit(t); });
    };
    ahead(2, [&](std::ptrdiff_t t) { ask(in.triangles + 3 * t), ask(in.material + t); });
    ahead(1, [&](std::ptrdiff_t t) {
        for (int k = 0; k < 3; ++k) ask(in.vertices + 8 * std::ptrdiff_t(in.triangles[3 * t + k]));
    });
}

// Squares of 16 pixels hold whole blocks, and tiles whole squares: no other thread writes there.
PLUMB_INLINE void mark(const GBufferArgs& in, const Block& b) {
    if (!in.covered) return;
    const glm::ivec2 tile = b.first >> Covered::shift;
    in.covered[std::ptrdiff_t(tile.y) * in.covered_columns + tile.x] = 1;
}

// From so many pixels on the targets of a frame are larger than a core's cache: to read them into it before they are
// overwritten would be waste.
constexpr std::ptrdiff_t many_pixels = 1 << 18;

// The branches that no target asks for fall away when this is compiled: with them textures, and normal maps.
template <bool with_colour, bool with_normal>
void gbuffer_tile(const GBufferArgs& in, const TilePixels& seen) {
    NoTap tap;
    const vec4<F> nothing(F(0.0f), F(0.0f), F(0.0f), F(0.0f));
    const bool past_caches = std::ptrdiff_t(in.width) * in.height >= many_pixels;
    for_blocks(seen, in.width, [&](const Block& b, std::ptrdiff_t at) {
        prefetch(in.surfaces, seen, at);
        GBufferPixel<F> out{nothing, nothing, nothing, nothing};
        if (any(b.covered)) {
            out = stored<F>(in, raster::gbuffer<F>(in, b.triangle, b.barycentrics, tap), b.x, b.y);
            mark(in, b);
        }
        put(in.position, in.width, out.position, b, past_caches);
        if (with_normal) put(in.normal, in.width, out.normal, b, past_caches);
        if (with_colour) put(in.albedo, in.width, out.albedo, b, past_caches);
        if (with_colour) put(in.emission, in.width, out.emission, b, past_caches);
    });
    if (past_caches) _mm_sfence();
}

template <bool with_normal, bool with_light>
void rsm_tile(const RsmArgs& in, const TilePixels& seen, const RsmStore& store) {
    NoTap tap;
    const vec4<F> nothing(F(0.0f), F(0.0f), F(0.0f), F(0.0f));
    for_blocks(seen, in.size, [&](const Block& b, std::ptrdiff_t at) {
        prefetch(in.surfaces, seen, at);
        RsmTexel<F> out{nothing, nothing, nothing};
        if (any(b.covered)) out = stored<F>(store, raster::rsm<F>(in, b.x, b.y, b.triangle, b.barycentrics, tap));
        put(in.position, in.size, out.position, b);
        if (with_normal) put(in.normal, in.size, out.normal, b);
        if (with_light) put(in.flux, in.size, out.flux, b);
    });
}

}  // namespace

template <>
void ResolveTile<Isa::PLUMB_ISA>::gbuffer(const GBufferArgs& in, const TilePixels& seen) {
    if (in.id)
        for_blocks(seen, in.width, [&](const Block& b, std::ptrdiff_t at) { put_ids(in, b, seen.triangle + at); });
    const bool colour = in.albedo || in.emission;
    if (colour && in.normal) return gbuffer_tile<true, true>(in, seen);
    if (colour) return gbuffer_tile<true, false>(in, seen);
    if (in.normal) return gbuffer_tile<false, true>(in, seen);
    if (in.position) return gbuffer_tile<false, false>(in, seen);
}

template <>
void ResolveTile<Isa::PLUMB_ISA>::rsm(const RsmArgs& in, const TilePixels& seen, const RsmStore& store) {
    if (in.flux) return rsm_tile<true, true>(in, seen, store);
    if (in.normal) return rsm_tile<true, false>(in, seen, store);
    rsm_tile<false, false>(in, seen, store);
}

}  // namespace plumb::raster
