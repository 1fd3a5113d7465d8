#include <cstring>

#include "raster/blocks.h"
#include "raster/visibility_kernel.h"

namespace plumb::raster {
namespace {

using namespace PLUMB_ISA;
using F = PLUMB_ISA::Real;
using D = PLUMB_ISA::Doubles;
using N = number<F>;
using I = index_t<F>;
using M = mask_t<F>;
constexpr int width = N::width;

template <class T>
struct Lanes {
    alignas(64) T lane[width];
};

// ---- vertices -------------------------------------------------------------------------------------------------------

PLUMB_INLINE vec4<F> clip_position(const VertexArgs& in, I i) {
    if (!in.vertices) return N::fetch4(in.clip, i);
    const vec4<F> p = N::fetch4(in.vertices, i * I(2));
    const D x = widen(p.x), y = widen(p.y), z = widen(p.z);
    const auto& m = in.world_to_clip;
    auto row = [&](int r) { return narrow(D(m[0][r]) * x + D(m[1][r]) * y + D(m[2][r]) * z + D(m[3][r])); };
    return {row(0), row(1), row(2), row(3)};
}

PLUMB_INLINE M finite(const vec4<F>& p) {
    const F zero(0.0f);
    return M((p.x - p.x == zero) & (p.y - p.y == zero) & (p.z - p.z == zero) & (p.w - p.w == zero));
}

PLUMB_INLINE I bit_where(M m, int bit) { return select(m, I(bit), I(0)); }

// Comparing is exact, so the frame's planes are. The guard band's are not: a vertex within a few 2^-20 of them, or with
// a w that a float hardly holds, is left to the clipping, which then finds it inside.
PLUMB_INLINE I planes_beyond(const VertexArgs& in, const vec4<F>& p) {
    const F zero(0.0f), lowest_w(0x1p-100f);
    const I frame = bit_where(p.z < zero, 1) | bit_where(p.w < p.z, 2) | bit_where(p.x < -p.w, 4) |
                    bit_where(p.w < p.x, 8) | bit_where(p.y < -p.w, 16) | bit_where(p.w < p.y, 32);
    const M simple = M((p.z >= zero) & (p.w >= p.z) & (p.w >= lowest_w) & (abs(p.x) <= F(in.guard[0]) * p.w) &
                       (abs(p.y) <= F(in.guard[1]) * p.w));
    return frame | select(simple, I(0), I(may_need_clipping));
}

// As snap() does it.
PLUMB_INLINE I snap_lanes(D clip, D w, int side) {
    return round_to_index(clip * D(128.0 * side) / w) + I(128 * (side - 1));
}

// ---- culling --------------------------------------------------------------------------------------------------------

struct Span {
    I low, high;    // of the corners, 1/256 pixel
    I first, last;  // pixels whose centres lie within, clipped to the frame
};
PLUMB_INLINE Span span(const I c[3], int side) {
    const I low = min(min(c[0], c[1]), c[2]), high = max(max(c[0], c[1]), c[2]);
    return {low, high, max((low + I(255)) >> 8, I(0)), min(high >> 8, I(side - 1))};
}

// Whether a triangle less than 64 pixels wide and high covers one of the four centres where its first and last columns
// and rows meet: products of differences are below 2^28.
PLUMB_INLINE M covers_corner(const I x[3], const I y[3], const Span& columns, const Span& rows) {
    const I area = (x[1] - x[0]) * (y[2] - y[0]) - (y[1] - y[0]) * (x[2] - x[0]);
    const I sign = select(area > I(0), I(1), I(-1));
    const I wide = (columns.last - columns.first) << 8, high = (rows.last - rows.first) << 8;
    I slack[3], right[3], down[3];
#pragma GCC unroll 3
    for (int i = 0; i < 3; ++i) {
        const int a = (i + 1) % 3, b = (i + 2) % 3;
        const I dx = sign * (x[b] - x[a]), dy = sign * (y[b] - y[a]);
        const M top_left = M((dy < I(0)) | ((dy == I(0)) & (dx > I(0))));
        const I e = dx * ((rows.first << 8) - y[a]) + dy * (x[a] - (columns.first << 8));
        slack[i] = select(top_left, e, e - I(1));
        right[i] = I(0) - dy * wide, down[i] = dx * high;
    }
    auto outside = [&](const I o[3]) { return any_negative(slack[0] + o[0], slack[1] + o[1], slack[2] + o[2]); };
    const I none[3] = {I(0), I(0), I(0)};
    const I both[3] = {right[0] + down[0], right[1] + down[1], right[2] + down[2]};
    return !M(M(outside(none) & outside(right)) & M(outside(down) & outside(both)));
}

// ---- drawing --------------------------------------------------------------------------------------------------------

// What is drawn into: a tile's blocks, row by row of blocks. Reversed depths are kept negated, so that nearer is less.
struct Tile {
    glm::ivec2 origin, end;  // pixels of the frame; end is clipped to the frame
    int side;
    float* nearest;
    std::int32_t* winner;
    float sign;
    const float* behind;  // what lies farther is drawn; read where draw_triangle() peels

    // Where the block lies whose first pixel is (x, y) of the frame.
    PLUMB_INLINE std::ptrdiff_t block(int x, int y) const {
        return block_at(side, x - origin.x, y - origin.y);
    }
};

// The columns and rows of the tile that the triangle's box holds, inclusive.
struct Box {
    int left, right, top, bottom;
    bool small;
};
PLUMB_INLINE Box box_in(const Tile& tile, const ScreenTriangle& t) {
    const int low_x = min(min(t.x[0], t.x[1]), t.x[2]), high_x = max(max(t.x[0], t.x[1]), t.x[2]);
    const int low_y = min(min(t.y[0], t.y[1]), t.y[2]), high_y = max(max(t.y[0], t.y[1]), t.y[2]);
    return {max(tile.origin.x, (low_x + 255) >> 8), min(tile.end.x - 1, high_x >> 8),
            max(tile.origin.y, (low_y + 255) >> 8), min(tile.end.y - 1, high_y >> 8),
            max(high_x - low_x, high_y - low_y) < 64 * 256};
}

// Edge functions of a block's lanes are 32-bit integers where the triangle is less than 64 pixels wide and high (below
// 2^30, also in the lanes of the block that lie outside), else doubles, exact too (below 2^53).
template <class E>
struct Scalar {
    using Type = double;
    static PLUMB_INLINE D lanes(I i) { return widen(i); }
};
template <>
struct Scalar<I> {
    using Type = std::int32_t;
    static PLUMB_INLINE I lanes(I i) { return i; }
};

// Draws a triangle into a tile. Of equal depths the earlier triangle's stays, in whatever order they come.
// `alpha_test(e, wins)` may take lanes away from those that pass the depth test. peels: only what lies strictly behind
// tile.behind passes; the same triangle has the same depth there, to the bit, and is not drawn again.
template <bool peels, class E, class AlphaTest>
PLUMB_INLINE void draw_triangle(const ScreenTriangle& t, std::int32_t id, const Box& box, const Tile& tile,
                                const AlphaTest& alpha_test) {
    using S = typename Scalar<E>::Type;
    const S area = S(t.x[1] - t.x[0]) * S(t.y[2] - t.y[0]) - S(t.y[1] - t.y[0]) * S(t.x[2] - t.x[0]);
    const int sign = area > 0 ? 1 : -1;
    const double scale = 1 / double(S(sign) * area);
    const int first = box.left & -block_width, top = box.top & -block_height;
    const I columns = lane_columns() << 8, rows = lane_rows() << 8;
    E edge[3], right[3], down[3], least[3];
    D z[3];
#pragma GCC unroll 3
    for (int i = 0; i < 3; ++i) {
        // As edge_row() does it.
        const int a = (i + 1) % 3, b = (i + 2) % 3;
        const int dx = sign * (t.x[b] - t.x[a]), dy = sign * (t.y[b] - t.y[a]);
        edge[i] = E(S(dx)) * Scalar<E>::lanes(rows + I(256 * top - t.y[a])) -
                  E(S(dy)) * Scalar<E>::lanes(columns + I(256 * first - t.x[a]));
        right[i] = E(S(-256 * block_width) * S(dy));
        down[i] = E(S(256 * block_height) * S(dx));
        least[i] = E(S(dy < 0 || (dy == 0 && dx > 0) ? 0 : 1));
        // Adding 0 turns a depth of -0 into 0: no sum of lanes that are covered is then -0 before the sign is applied.
        z[i] = D(double(tile.sign) * (t.z[i] * scale + 0.0));
    }
    std::ptrdiff_t at_row = tile.block(first, top);
    for (int y = top; y <= box.bottom; y += block_height, at_row += block_height * tile.side) {
        E e[3] = {edge[0], edge[1], edge[2]};
        std::ptrdiff_t at = at_row;
        for (int x = first; x <= box.right; x += block_width, at += width) {
            const M inside = !any_negative(e[0] - least[0], e[1] - least[1], e[2] - least[2]);
            if (any(inside)) {
                const D sum = widen(e[0]) * z[0] + widen(e[1]) * z[1] + widen(e[2]) * z[2];
                const F depth = max(min(narrow(sum), F(1.0f)), F(-1.0f)), nearest = load_lanes(tile.nearest + at);
                const I winner = load_lanes(tile.winner + at);
                M passes = M((depth < nearest) | M((depth == nearest) & (I(id) < winner)));
                if constexpr (peels) passes = M(passes & (depth > load_lanes(tile.behind + at)));
                const M wins = alpha_test(e, M(inside & passes));
                // To ask first whether any lane wins would cost more, in branches that no processor foresees.
                store_lanes(tile.nearest + at, select(wins, depth, nearest));
                store_lanes(tile.winner + at, select(wins, I(id), winner));
            }
#pragma GCC unroll 3
            for (int i = 0; i < 3; ++i) e[i] = e[i] + right[i];
        }
#pragma GCC unroll 3
        for (int i = 0; i < 3; ++i) edge[i] = edge[i] + down[i];
    }
}

// True where all that is drawn in the triangle's box is nearer than the triangle: its depths are not nearer than its
// nearest corner's, and rounding to float keeps that order.
PLUMB_INLINE bool hidden(const ScreenTriangle& t, const Box& box, const Tile& tile) {
    const double sign = tile.sign;
    const F bound(float(min(min(sign * t.z[0], sign * t.z[1]), sign * t.z[2]) - depth_slack));
    for (int y = box.top & -block_height; y <= box.bottom; y += block_height)
        for (int x = box.left & -block_width; x <= box.right; x += block_width)
            if (any(M(load_lanes(tile.nearest + tile.block(x, y)) >= bound))) return false;
    return true;
}

// True where one edge leaves all of the box outside.
PLUMB_INLINE bool misses(const ScreenTriangle& t, const Box& box) {
    const bool clockwise = area2(t) > 0;
    for (int i = 0; i < 3; ++i) {
        const EdgeRow top = edge_row(t, clockwise, i, box.top), bottom = edge_row(t, clockwise, i, box.bottom);
        const std::int64_t most = top.value > bottom.value ? top.value : bottom.value;
        if (most + top.step * (top.step > 0 ? box.right : box.left) < top.least) return true;
    }
    return false;
}

// l1, l2 as quotients, at points with edge functions e: barycentrics() divides the same numbers.
struct Quotients {
    D l1, l2, sum;
};
template <class E>
PLUMB_INLINE Quotients quotients(const ScreenTriangle& t, const PieceCorners* corners, const E* e) {
    const D q0 = widen(e[0]) * D(t.inverse_w[0]), q1 = widen(e[1]) * D(t.inverse_w[1]),
            q2 = widen(e[2]) * D(t.inverse_w[2]);
    // Returned at one place, so that a compiler keeps them in registers: a masked read of what was just stored waits.
    D l1 = q1, l2 = q2;
    if (t.corners >= 0) {
        const glm::dvec2* l = corners[t.corners].barycentrics;
        l1 = q0 * D(l[0].x) + q1 * D(l[1].x) + q2 * D(l[2].x), l2 = q0 * D(l[0].y) + q1 * D(l[1].y) + q2 * D(l[2].y);
    }
    return {l1, l2, q0 + q1 + q2};
}
PLUMB_INLINE vec2<F> barycentrics_of(const Quotients& q) { return {narrow(q.l1 / q.sum), narrow(q.l2 / q.sum)}; }

template <bool peels, class E>
PLUMB_INLINE void draw_opaque(const ScreenTriangle& t, std::int32_t id, const Box& box, const Tile& tile) {
    draw_triangle<peels, E>(t, id, box, tile, [](const E*, M wins) { return wins; });
}

template <bool peels>
void draw_entry(const TileArgs& in, const ChunkView& chunk, int entry, std::int32_t first_id, const Tile& tile) {
    const int k = entry & (masked - 1);
    const ScreenTriangle& t = chunk.triangles[k];
    const Box box = box_in(tile, t);
    if (box.left > box.right || box.top > box.bottom) return;
    if (hidden(t, box, tile)) return;
    if (!box.small && misses(t, box)) return;
    if (entry & masked) {
        // Masks are rare: one form of edge functions serves all sizes.
        draw_triangle<peels, D>(t, first_id + k, box, tile, [&](const D* e, M wins) {
            return any(wins) ? M(wins & passes_alpha<F>(*in.surfaces, I(t.triangle),
                                                        barycentrics_of(quotients(t, chunk.corners, e))))
                             : wins;
        });
    } else if (box.small) {
        draw_opaque<peels, I>(t, first_id + k, box, tile);
    } else {
        draw_opaque<peels, D>(t, first_id + k, box, tile);
    }
}

// Of each lane the farthest depth in all blocks.
F farthest_in(const Tile& tile, int blocks) {
    F farthest(-1.0f);
    for (int i = 0; i < blocks; ++i) farthest = max(farthest, load_lanes(tile.nearest + i * width));
    return farthest;
}

// Merges what touches this tile and what touches many, both in drawing order. Returns the number of entries.
template <bool peels>
PLUMB_INLINE int draw_chunk(const TileArgs& in, const ChunkView& chunk, int index, int tile_index, const Tile& tile) {
    const std::uint16_t* const a_first = chunk.entries + chunk.start[tile_index];
    const std::uint16_t* a = a_first;
    const std::uint16_t* const a_end = chunk.entries + chunk.start[tile_index + 1];
    const std::uint16_t* b = chunk.large;
    const std::uint16_t* const b_end = b + chunk.large_count;
    auto order = [](std::uint16_t entry) { return entry & (masked - 1); };
    while (a < a_end || b < b_end) {
        const bool take_a = b == b_end || (a < a_end && order(*a) < order(*b));
        if (a + 4 < a_end) {
            const char* ahead = reinterpret_cast<const char*>(chunk.triangles + order(a[4]));
            __builtin_prefetch(ahead), __builtin_prefetch(ahead + 64);
        }
        draw_entry<peels>(in, chunk, take_a ? *a++ : *b++, index << chunk_bits, tile);
    }
    return int(a_end - a_first) + chunk.large_count;
}

// Near chunks hide far ones: those behind all that is drawn need not be looked at.
template <bool peels>
void draw_chunks(const TileArgs& in, int tile_index, const Tile& tile) {
    const int blocks = in.side * in.side / width;
    F farthest(1.0f);
    for (int i = 0, drawn = 0; i < in.chunk_count; ++i) {
        const ChunkView& chunk = in.chunks[in.order[i]];
        if (drawn >= blocks) farthest = farthest_in(tile, blocks), drawn = 0;
        if (!any(M(farthest >= F(chunk.nearest)))) break;
        drawn += draw_chunk<peels>(in, chunk, in.order[i], tile_index, tile);
    }
}

// Copies the tile's part of in.behind into blocks, as depths are kept there. Nothing is drawn outside of the frame.
void get_behind(const TileArgs& in, const Tile& tile, float* behind) {
    for (int i = 0; i < in.side * in.side; i += width) store_lanes(behind + i, F(1.0f));
    for (int y = tile.origin.y; y < tile.end.y; ++y)
        for (int x = tile.origin.x; x < tile.end.x; ++x) {
            const int column = (x - tile.origin.x) % block_width, row = (y - tile.origin.y) % block_height;
            behind[tile.block(x - column, y - row) + row * block_width + column] =
                tile.sign * in.behind[std::ptrdiff_t(y) * in.size.x + x];
        }
}

// ---- resolving ------------------------------------------------------------------------------------------------------

PLUMB_INLINE const ScreenTriangle& seen_by(const TileArgs& in, std::int32_t id) {
    return in.chunks[id >> chunk_bits].triangles[id & (masked - 1)];
}

// Turns a block's winners into what it sees: one evaluation for each of its triangles, and one division for all.
PLUMB_INLINE void resolve_block(const TileArgs& in, const Tile& tile, const TilePixels& out, int x, int y) {
    const std::ptrdiff_t at = tile.block(x, y);
    const I winner = load_lanes(tile.winner + at);
    I triangle(-1);
    Quotients q{D(0.0), D(0.0), D(1.0)};
    for_distinct(winner, tile.winner + at, lane_bits(winner >= I(0)), [&](std::int32_t id, M here) {
        const ScreenTriangle& t = seen_by(in, id);
        const bool clockwise = area2(t) > 0;
        D e[3];
#pragma GCC unroll 3
        for (int i = 0; i < 3; ++i) {
            const EdgeRow edge = edge_row(t, clockwise, i, y);
            const int dx = t.x[(i + 2) % 3] - t.x[(i + 1) % 3];
            e[i] = D(double(edge.value + edge.step * x)) + D(double(edge.step)) * widen(lane_columns()) +
                   D(256.0 * double(clockwise ? dx : -dx)) * widen(lane_rows());
        }
        const Quotients here_q = quotients(t, in.chunks[id >> chunk_bits].corners, e);
        triangle = select(here, I(t.triangle), triangle);
        q = {select(here, here_q.l1, q.l1), select(here, here_q.l2, q.l2), select(here, here_q.sum, q.sum)};
    });
    const vec2<F> l = barycentrics_of(q);
    store_lanes(out.triangle + at, triangle);
    store_lanes(out.l1 + at, l.x), store_lanes(out.l2 + at, l.y);
}

// Copies a block's values to rows of a frame, `stride` values a pixel and `pitch` a row, from the block's first pixel
// on: as many columns and rows as lie before `end`.
template <int stride, class T>
PLUMB_INLINE void put_block(const T* block, T* target, std::ptrdiff_t pitch, glm::ivec2 pixels) {
    if (pixels.x >= block_width && pixels.y >= block_height) {
        for (int row = 0; row < block_height; ++row)
            std::memcpy(target + row * pitch, block + row * stride * block_width, stride * block_width * sizeof(T));
        return;
    }
    for (int row = 0; row < min(block_height, pixels.y); ++row)
        for (int k = 0; k < stride * min(block_width, pixels.x); ++k)
            target[row * pitch + k] = block[row * stride * block_width + k];
}

}  // namespace

template <>
int VisibilityKernels<Isa::PLUMB_ISA>::window_vertices(const VertexArgs& in, int first, int last) {
    int wrong = INT_MAX;
    for (int i = first; i < last; i += width) {
        const vec4<F> p = clip_position(in, min(N::iota(i), I(last - 1)));
        if (const unsigned bad = lane_bits(!finite(p)); bad && wrong == INT_MAX) wrong = i + __builtin_ctz(bad);
        const D w = widen(p.w);
        const I x = snap_lanes(widen(p.x), w, in.size.x), y = snap_lanes(widen(p.y), w, in.size.y);
        const F x_beyond = N::from_bits((x << beyond_bits) | planes_beyond(in, p));
        if (last - i >= width) {
            store_quads(reinterpret_cast<float*>(in.window + i), x_beyond, N::from_bits(y), p.z, p.w);
        } else {
            alignas(64) WindowVertex rest[width];
            store_quads(reinterpret_cast<float*>(rest), x_beyond, N::from_bits(y), p.z, p.w);
            for (int k = 0; k < last - i; ++k) in.window[i + k] = rest[k];
        }
    }
    return wrong;
}

template <>
int VisibilityKernels<Isa::PLUMB_ISA>::cull(const CullArgs& in, int first, int last, std::int32_t* kept) {
    int count = 0;
    for (int i = first; i < last; i += width) {
        const I corner = min(N::iota(i), I(last - 1)) * I(3);
        I x[3], y[3], all(-1), some(0);
        for (int c = 0; c < 3; ++c) {
            const I vertex = N::fetch(in.triangles, corner + I(c));
            const vec4<F> v = N::fetch4(reinterpret_cast<const float*>(in.window), vertex);
            x[c] = N::bits(v.x) >> beyond_bits, y[c] = N::bits(v.y);
            all = all & N::bits(v.x), some = some | N::bits(v.x);
        }
        const M within = M(((all & I(frame_planes)) == I(0)) & (N::iota(i) < I(last)));
        if (!any(within)) continue;
        const M clipped = M(within & ((some & I(may_need_clipping)) > I(0)));

        // Most triangles of a fine mesh lie between the centres. Where there are at most two columns and two rows of
        // them, to look at each is cheaper than to draw.
        const Span columns = span(x, in.size.x), rows = span(y, in.size.y);
        const I wide = columns.last - columns.first, high = rows.last - rows.first, most(64 * 256);
        M seen = M(within & M((wide >= I(0)) & (high >= I(0))));
        const M tiny = M(M((wide <= I(1)) & (high <= I(1))) &
                         M((columns.high - columns.low < most) & (rows.high - rows.low < most)));
        if (any(M(seen & tiny))) seen = M(seen & M(M(!tiny) | covers_corner(x, y, columns, rows)));

        const unsigned to_clip = lane_bits(clipped);
        for (unsigned left = lane_bits(M(seen | clipped)); left; left &= left - 1) {
            const int k = __builtin_ctz(left);
            kept[count++] = to_clip >> k & 1 ? -1 - (i + k) : i + k;
        }
    }
    return count;
}

template <>
void VisibilityKernels<Isa::PLUMB_ISA>::draw_tile(const TileArgs& in, int tile_index, const TilePixels& out,
                                                  float* nearest, float* behind) {
    // Winners become triangles in place, block by block.
    Tile tile{out.origin, out.end, out.side, nearest, out.triangle, in.reversed_z ? -1.0f : 1.0f, nullptr};
    for (int i = 0; i < in.side * in.side; i += width) {
        store_lanes(nearest + i, F(in.reversed_z ? -0.0f : 1.0f));
        store_lanes(tile.winner + i, I(-1));
    }
    if (in.behind) {
        get_behind(in, tile, behind);
        tile.behind = behind;
        draw_chunks<true>(in, tile_index, tile);
    } else {
        draw_chunks<false>(in, tile_index, tile);
    }
    for (int y = out.origin.y; y < out.end.y; y += block_height)
        for (int x = out.origin.x; x < out.end.x; x += block_width) {
            resolve_block(in, tile, out, x, y);
            Lanes<float> depth;
            store_lanes(depth.lane, load_lanes(nearest + tile.block(x, y)) * F(tile.sign));
            put_block<1>(depth.lane, in.depth + std::ptrdiff_t(y) * in.size.x + x, in.size.x,
                         out.end - glm::ivec2(x, y));
        }
}

template <>
void VisibilityKernels<Isa::PLUMB_ISA>::write_rows(const TilePixels& in, int frame_width, std::int32_t* triangle,
                                                   float* barycentrics) {
    for (int y = in.origin.y; y < in.end.y; y += block_height)
        for (int x = in.origin.x; x < in.end.x; x += block_width) {
            const std::ptrdiff_t at = block_at(in.side, x - in.origin.x, y - in.origin.y);
            const std::ptrdiff_t pixel = std::ptrdiff_t(y) * frame_width + x;
            const glm::ivec2 pixels = in.end - glm::ivec2(x, y);
            alignas(64) float pairs[2 * width];
            store_pairs(pairs, load_lanes(in.l1 + at), load_lanes(in.l2 + at));
            put_block<1>(in.triangle + at, triangle + pixel, frame_width, pixels);
            put_block<2>(pairs, barycentrics + 2 * pixel, 2 * std::ptrdiff_t(frame_width), pixels);
        }
}

}  // namespace plumb::raster
