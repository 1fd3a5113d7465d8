// The visibility pass in three kernels, compiled once per instruction set (visibility_isa.cpp): vertices to window
// space, culling of triangles, drawing of a tile. visibility.cpp runs them; visibility_reference.cpp says the same
// slowly.
#pragma once

#include <climits>
#include <cstdint>
#include <glm/glm.hpp>

#include "core/isa.h"
#include "raster/screen_triangle.h"
#include "raster/surface_kernel.h"
#include "raster/visible_tiles.h"

namespace plumb::raster {

// A vertex in window space: 1/256 pixel, and z and w of its clip position. The low bits of `x_beyond` are one for every
// plane of the frame that the vertex is beyond, and `may_need_clipping`; where that one is set, x and y may be anything.
struct WindowVertex {
    std::int32_t x_beyond, y;
    float z, w;
};
inline constexpr int beyond_bits = 7;
inline constexpr int frame_planes = 63, may_need_clipping = 64;

struct VertexArgs {
    const float* vertices;  // [vertex][8]: position m first; null: clip positions are given
    const float* clip;      // [vertex][4]
    double world_to_clip[4][4];
    glm::ivec2 size;
    float guard[2];         // a little less than the guard band's
    WindowVertex* window;
};

struct CullArgs {
    const std::int32_t* triangles;  // [triangle][3]
    const WindowVertex* window;
    glm::ivec2 size;
};

// Triangles are drawn in chunks: a chunk's part of what the tiles read. An entry is an index into `triangles`, and
// `masked` where the triangle's material has an alpha mask. Entries are in drawing order.
struct ChunkView {
    const ScreenTriangle* triangles;
    const PieceCorners* corners;
    const std::uint32_t* start;    // entries[start[tile]..start[tile + 1]) touch the tile
    const std::uint16_t* entries;
    const std::uint16_t* large;    // touch many tiles: looked at by every one
    std::int32_t large_count;
    float nearest;                 // no depth of the chunk is nearer; reversed depths are negated
};
// Depths are weighted means of the corners', up to a rounding of some 2^-51.
inline constexpr double depth_slack = 0x1p-49;
inline constexpr int chunk_triangles = 4096;
inline constexpr int chunk_bits = 15;  // 4096 triangles clipped to 7 pieces each are fewer than 2^15
inline constexpr std::uint16_t masked = 1 << chunk_bits;

struct TileArgs {
    const ChunkView* chunks;
    const std::int32_t* order;   // of the chunks, the nearest first
    int chunk_count;
    glm::ivec2 size;
    int side;                    // of a tile, pixels: 64 or a larger power of two
    bool reversed_z;
    const SurfaceArgs* surfaces;  // read for masked triangles alone
    float* depth;                 // of the frame, out
    const float* behind;          // of the frame: only what lies farther is drawn; null: everything is
};

template <Isa isa>
struct VisibilityKernels {
    // Vertices [first, last). Returns the first whose clip position is not finite, or INT_MAX.
    static int window_vertices(const VertexArgs& in, int first, int last);

    // Lists those of triangles [first, last) that may be seen, in order: i, or -1 - i where it has to be clipped. What
    // is left out covers no pixel centre. Returns their number.
    static int cull(const CullArgs& in, int first, int last, std::int32_t* kept);

    // Draws all chunks into a tile, fills `out` and writes the tile's part of the depth buffer. `nearest` and, where
    // in.behind is there, `behind` are scratch memory, side x side.
    static void draw_tile(const TileArgs& in, int tile, const TilePixels& out, float* nearest, float* behind);

    // Writes a tile's part of a VisibilityBuffer of the width.
    static void write_rows(const TilePixels& in, int width, std::int32_t* triangle, float* barycentrics);
};

}  // namespace plumb::raster
