#include <cstring>

#include "raster/visibility_kernel.h"
#include "raster/wide_double.h"

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

// A packet of lanes is a block of pixels, nearly square: small triangles then touch few of them. Lane k is column
// k % block_width and row k / block_width.
constexpr int block_shift = width >= 8 ? 2 : width >= 4 ? 1 : 0, block_width = 1 << block_shift,
              block_height = width / block_width;

// What is drawn into: a tile's blocks, row by row of blocks. Reversed depths are kept negated, so that nearer is less.
struct Tile {
    glm::ivec2 origin, end;  // pixels of the frame; end is clipped to the frame
    int side;
    float* nearest;
    std::int32_t* winner;
    float sign;

    // Where the block lies whose first pixel is (x, y) of the frame.
    PLUMB_INLINE std::ptrdiff_t block(int x, int y) const {
        return std::ptrdiff_t(y - origin.y) * side + (x - origin.x) * block_height;
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
// `alpha_test(e, wins)` may take lanes away from those that pass the depth test.
template <class E, class AlphaTest>
PLUMB_INLINE void draw_triangle(const ScreenTriangle& t, std::int32_t id, const Box& box, const Tile& tile,
                                const AlphaTest& alpha_test) {
    using S = typename Scalar<E>::Type;
    const S area = S(t.x[1] - t.x[0]) * S(t.y[2] - t.y[0]) - S(t.y[1] - t.y[0]) * S(t.x[2] - t.x[0]);
    const int sign = area > 0 ? 1 : -1;
    const double scale = 1 / double(S(sign) * area);
    const int first = box.left & -block_width, top = box.top & -block_height;
    const I columns = (N::iota(0) & I(block_width - 1)) << 8, rows = (N::iota(0) >> block_shift) << 8;
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
                const M passes = M((depth < nearest) | M((depth == nearest) & (I(id) < winner)));
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

// l1, l2 at points with edge functions e: as barycentrics(), for one triangle.
template <class E>
PLUMB_INLINE vec2<F> barycentrics_of(const ScreenTriangle& t, const PieceCorners* corners, const E* e) {
    const D q0 = widen(e[0]) * D(t.inverse_w[0]), q1 = widen(e[1]) * D(t.inverse_w[1]),
            q2 = widen(e[2]) * D(t.inverse_w[2]);
    const D sum = q0 + q1 + q2;
    if (t.corners < 0) return {narrow(q1 / sum), narrow(q2 / sum)};
    const glm::dvec2* l = corners[t.corners].barycentrics;
    return {narrow((q0 * D(l[0].x) + q1 * D(l[1].x) + q2 * D(l[2].x)) / sum),
            narrow((q0 * D(l[0].y) + q1 * D(l[1].y) + q2 * D(l[2].y)) / sum)};
}

template <class E>
PLUMB_INLINE void draw_opaque(const ScreenTriangle& t, std::int32_t id, const Box& box, const Tile& tile) {
    draw_triangle<E>(t, id, box, tile, [](const E*, M wins) { return wins; });
}

void draw_entry(const TileArgs& in, const ChunkView& chunk, int entry, std::int32_t first_id, const Tile& tile) {
    const int k = entry & (masked - 1);
    const ScreenTriangle& t = chunk.triangles[k];
    const Box box = box_in(tile, t);
    if (box.left > box.right || box.top > box.bottom) return;
    if (hidden(t, box, tile)) return;
    if (!box.small && misses(t, box)) return;
    if (entry & masked) {
        // Masks are rare: one form of edge functions serves all sizes.
        draw_triangle<D>(t, first_id + k, box, tile, [&](const D* e, M wins) {
            return any(wins) ? M(wins & passes_alpha<F>(*in.surfaces, I(t.triangle),
                                                        barycentrics_of(t, chunk.corners, e)))
                             : wins;
        });
    } else if (box.small) {
        draw_opaque<I>(t, first_id + k, box, tile);
    } else {
        draw_opaque<D>(t, first_id + k, box, tile);
    }
}

// Of each lane the farthest depth in all blocks.
F farthest_in(const Tile& tile, int blocks) {
    F farthest(-1.0f);
    for (int i = 0; i < blocks; ++i) farthest = max(farthest, load_lanes(tile.nearest + i * width));
    return farthest;
}

// Merges what touches this tile and what touches many, both in drawing order. Returns the number of entries.
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
        draw_entry(in, chunk, take_a ? *a++ : *b++, index << chunk_bits, tile);
    }
    return int(a_end - a_first) + chunk.large_count;
}

// ---- resolving ------------------------------------------------------------------------------------------------------

PLUMB_INLINE const ScreenTriangle& seen_by(const TileArgs& in, std::int32_t id) {
    return in.chunks[id >> chunk_bits].triangles[id & (masked - 1)];
}

// A strip of pixels of one row, packet by packet: what each pixel sees. Filled whole before it is read, so that no load
// waits for the stores just before it.
constexpr int strip = 64;
struct Strip {
    unsigned covered[strip], pieces[strip];  // of each packet, a bit a lane; pieces: of clipped triangles
    std::int32_t only[strip];                // the packet's winner where there is one for all that is covered, else -1
    alignas(64) std::int32_t x[3][strip], y[3][strip], triangle[strip];
    alignas(64) double inverse_w[3][strip];
};

PLUMB_INLINE void fetch_packet(const TileArgs& in, const std::int32_t* winner, int at, Strip& out) {
    const I ids = load_lanes(winner + at);
    const unsigned covered = lane_bits(ids >= I(0));
    const int packet = at / width;
    out.covered[packet] = covered, out.pieces[packet] = 0, out.only[packet] = -1;
    if (!covered) return;
    const std::int32_t some = winner[at + __builtin_ctz(covered)];
    if ((lane_bits(ids == I(some)) & covered) == covered) {
        out.only[packet] = some;
        return;
    }
    for (int k = at; k < at + width; ++k) {
        const ScreenTriangle& t = seen_by(in, winner[k] < 0 ? some : winner[k]);
#pragma GCC unroll 3
        for (int i = 0; i < 3; ++i) {
            out.x[i][k] = t.x[i], out.y[i][k] = t.y[i];
            out.inverse_w[i][k] = t.inverse_w[i];
        }
        out.triangle[k] = t.triangle;
        out.pieces[packet] |= unsigned(t.corners >= 0) << (k - at);
    }
}

// As barycentrics(), each lane with its own triangle. Edge functions of a counter-clockwise triangle are all negative
// here: the quotients are the same but for a zero's sign, which the sum with 0 makes positive.
PLUMB_INLINE vec2<F> barycentrics_of(const Strip& seen, int at, int column, int row) {
    D q[3];
#pragma GCC unroll 3
    for (int i = 0; i < 3; ++i) {
        const int a = (i + 1) % 3, b = (i + 2) % 3;
        const I xa = load_lanes(seen.x[a] + at), ya = load_lanes(seen.y[a] + at);
        const I dx = load_lanes(seen.x[b] + at) - xa, dy = load_lanes(seen.y[b] + at) - ya;
        const D e = widen(dx) * widen(I(256 * row) - ya) + widen(dy) * widen(xa - (N::iota(column) << 8));
        q[i] = e * load_lanes(seen.inverse_w[i] + at);
    }
    const D sum = q[0] + q[1] + q[2];
    return {narrow(q[1] / sum) + F(0.0f), narrow(q[2] / sum) + F(0.0f)};
}

// The same where all lanes see one triangle.
PLUMB_INLINE vec2<F> barycentrics_of(const TileArgs& in, std::int32_t id, int column, int row) {
    const ScreenTriangle& t = seen_by(in, id);
    const bool clockwise = area2(t) > 0;
    D e[3];
#pragma GCC unroll 3
    for (int i = 0; i < 3; ++i) {
        const EdgeRow edge = edge_row(t, clockwise, i, row);
        e[i] = D(double(edge.value + edge.step * column)) + D(double(edge.step)) * widen(N::iota(0));
    }
    return barycentrics_of(t, in.chunks[id >> chunk_bits].corners, e);
}

glm::vec2 barycentrics_at(const TileArgs& in, std::int32_t id, int column, int row) {
    const ScreenTriangle& t = seen_by(in, id);
    const bool clockwise = area2(t) > 0;
    double e[3];
    for (int i = 0; i < 3; ++i) {
        const EdgeRow edge = edge_row(t, clockwise, i, row);
        e[i] = double(edge.value + edge.step * column);
    }
    return barycentrics(t, in.chunks[id >> chunk_bits].corners, e);
}

// Writes a packet's pixels, from column x on: n of them, which is `width` but at the frame's edge.
PLUMB_INLINE void resolve_packet(const TileArgs& in, const Strip& seen, int at, F nearest, const std::int32_t* winner,
                                 int x, int y, int n) {
    const std::ptrdiff_t pixel = std::ptrdiff_t(y) * in.size.x + x;
    const int packet = at / width;
    const unsigned covered = seen.covered[packet];
    const M is_covered = load_lanes(winner + at) >= I(0);
    I triangle(-1);
    vec2<F> l(F(0.0f));
    if (seen.only[packet] >= 0) {
        triangle = I(seen_by(in, seen.only[packet]).triangle);
        l = barycentrics_of(in, seen.only[packet], x, y);
    } else if (covered) {
        triangle = load_lanes(seen.triangle + at);
        l = barycentrics_of(seen, at, x, y);
    }
    triangle = select(is_covered, triangle, I(-1));
    l = {select(is_covered, l.x, F(0.0f)), select(is_covered, l.y, F(0.0f))};
    float* out = in.barycentrics + 2 * pixel;
    if (n == width) {
        store_lanes(in.triangle + pixel, triangle);
        store_lanes(in.depth + pixel, nearest);
        store_pairs(out, l.x, l.y);
    } else {
        Lanes<std::int32_t> ids;
        Lanes<float> depth, l1, l2;
        store_lanes(ids.lane, triangle), store_lanes(depth.lane, nearest);
        store_lanes(l1.lane, l.x), store_lanes(l2.lane, l.y);
        for (int k = 0; k < n; ++k) {
            in.triangle[pixel + k] = ids.lane[k], in.depth[pixel + k] = depth.lane[k];
            out[2 * k] = l1.lane[k], out[2 * k + 1] = l2.lane[k];
        }
    }
    for (unsigned left = seen.pieces[packet] & covered; left; left &= left - 1) {
        const int k = __builtin_ctz(left);
        if (k >= n) break;
        const glm::vec2 piece = barycentrics_at(in, winner[at + k], x + k, y);
        out[2 * k] = piece.x, out[2 * k + 1] = piece.y;
    }
}

// Writes `columns` pixels of a row of blocks, from (x, y) of the frame on, which is a block's first pixel. All blocks
// are put into rows before a row is read.
void resolve_strip(const TileArgs& in, const Tile& tile, int x, int y, int columns) {
    alignas(64) float nearest[block_height][strip];
    alignas(64) std::int32_t winner[block_height][strip];
    const std::ptrdiff_t first = tile.block(x, y);
    for (int k = 0; k < strip; k += block_width)
        for (int row = 0; row < block_height; ++row) {
            const std::ptrdiff_t at = first + k * block_height + row * block_width;
            std::memcpy(nearest[row] + k, tile.nearest + at, block_width * sizeof(float));
            std::memcpy(winner[row] + k, tile.winner + at, block_width * sizeof(std::int32_t));
        }
    for (int row = 0; row < min(block_height, tile.end.y - y); ++row) {
        Strip seen;
        for (int at = 0; at < columns; at += width) fetch_packet(in, winner[row], at, seen);
        for (int at = 0; at < columns; at += width)
            resolve_packet(in, seen, at, load_lanes(nearest[row] + at) * F(tile.sign), winner[row], x + at, y + row,
                           min(width, columns - at));
    }
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
void VisibilityKernels<Isa::PLUMB_ISA>::draw_tile(const TileArgs& in, int tile_index, glm::ivec2 origin, float* nearest,
                                                  std::int32_t* winner) {
    Tile tile{origin, {min(in.size.x, origin.x + in.side), min(in.size.y, origin.y + in.side)}, in.side, nearest,
              winner, in.reversed_z ? -1.0f : 1.0f};
    for (int i = 0; i < in.side * in.side; i += width) {
        store_lanes(nearest + i, F(in.reversed_z ? -0.0f : 1.0f));
        store_lanes(winner + i, I(-1));
    }
    // Near chunks hide far ones: those behind all that is drawn need not be looked at.
    const int blocks = in.side * in.side / width;
    F farthest(1.0f);
    for (int i = 0, drawn = 0; i < in.chunk_count; ++i) {
        const ChunkView& chunk = in.chunks[in.order[i]];
        if (drawn >= blocks) farthest = farthest_in(tile, blocks), drawn = 0;
        if (!any(M(farthest >= F(chunk.nearest)))) break;
        drawn += draw_chunk(in, chunk, in.order[i], tile_index, tile);
    }
    for (int y = origin.y; y < tile.end.y; y += block_height)
        for (int x = origin.x; x < tile.end.x; x += strip) resolve_strip(in, tile, x, y, min(strip, tile.end.x - x));
}

}  // namespace plumb::raster
