#include "raster/visibility.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <numeric>

#include "core/error.h"
#include "core/parallel.h"
#include "raster/surfaces.h"
#include "raster/visibility_kernel.h"
#include "raster/visibility_reference.h"
#include "raster/visible_tiles.h"
#include "raster/workspace.h"

namespace plumb::raster {
namespace {

constexpr int max_tiles = 4096;
constexpr int few_tiles = 16;  // a triangle that touches more is `large`
constexpr std::size_t max_triangles = std::size_t(chunk_triangles) << (31 - chunk_bits);

// The frame cut into squares of 64 pixels, larger where there would be too many.
struct Tiles {
    int shift = 6;
    glm::ivec2 count;
    explicit Tiles(glm::ivec2 size) {
        while (true) {
            count = {((size.x - 1) >> shift) + 1, ((size.y - 1) >> shift) + 1};
            if (count.x * count.y <= max_tiles) break;
            ++shift;
        }
    }
    int total() const { return count.x * count.y; }
    int side() const { return 1 << shift; }
};

// What a call draws: a view's picture of the geometry, or clip positions that are given.
struct Source {
    const Geometry& geometry;
    const Surfaces* surfaces;
    glm::dmat4 world_to_clip;
    const Buffer<glm::vec4>* clip;
    bool reversed_z;

    glm::vec4 position(std::uint32_t vertex) const {
        return clip ? (*clip)[vertex] : clip_position(world_to_clip, geometry.vertices[vertex].position);
    }
    bool is_masked(std::int32_t triangle) const {
        if (!surfaces || !surfaces->any_masked) return false;
        return surfaces->masked[std::size_t(geometry.material[std::size_t(triangle)])] != 0;
    }
};

// Transforms all vertices. Throws for the first that is not finite.
void transform_vertices(const Source& source, glm::ivec2 size, const RunOptions& options, Workspace& memory) {
    const std::size_t n = source.clip ? source.clip->size() : source.geometry.vertices.size();
    VertexArgs args{};
    if (source.clip)
        args.clip = n ? &source.clip->data()->x : nullptr;
    else
        args.vertices = n ? &source.geometry.vertices.data()->position.x : nullptr;
    for (int c = 0; c < 4; ++c)
        for (int r = 0; r < 4; ++r) args.world_to_clip[c][r] = source.world_to_clip[c][r];
    args.size = size;
    const ClipVolume volume = clip_volume(size);
    for (int axis = 0; axis < 2; ++axis) args.guard[axis] = float(volume.guard[axis] * (1 - 0x1p-20));
    args.window = memory.window.reserve(n);

    std::atomic<int> wrong{INT_MAX};
    dispatch(options.isa, [&](auto isa) {
        parallel_bands(int(n), 4096, options.threads, [&](int first, int last) {
            const int here = VisibilityKernels<isa()>::window_vertices(args, first, last);
            for (int now = wrong; here < now && !wrong.compare_exchange_weak(now, here);) {}
        });
    });
    if (wrong == INT_MAX) return;
    if (source.clip)
        throw InputError(fmt::format("raster: vertex {}: its clip position is not finite", wrong.load()));
    throw_not_finite(source.geometry, wrong);
}

// Appends a triangle that needs no clipping, from vertices that are in window space already. It is built where it will
// lie: a copy would wait for all of its stores.
void append_window_triangle(const WindowVertex* window, const glm::uvec3& corners, std::int32_t triangle,
                            std::vector<ScreenTriangle>& out) {
    ScreenTriangle& t = out.emplace_back();
    for (int i = 0; i < 3; ++i) {
        const WindowVertex& v = window[corners[i]];
        t.x[i] = v.x_beyond >> beyond_bits, t.y[i] = v.y;
        t.z[i] = double(v.z) / double(v.w), t.inverse_w[i] = 1 / double(v.w);
    }
    t.triangle = triangle;
    t.corners = -1;
    if (area2(t) == 0) out.pop_back();
}

// Lists what may be seen of triangles [first, last), in their order: as append_triangle does it, but for triangles that
// cover no pixel centre.
void collect(const Source& source, glm::ivec2 size, const WindowVertex* window, const std::int32_t* kept,
             int count, ScreenTriangles& out) {
    const ClipVolume volume = clip_volume(size);
    out.triangles.clear();
    out.corners.clear();
    out.triangles.reserve(std::size_t(count));
    for (int k = 0; k < count; ++k) {
        const std::int32_t i = kept[k] < 0 ? -1 - kept[k] : kept[k];
        const glm::uvec3& c = source.geometry.triangles[std::size_t(i)];
        if (kept[k] < 0) {
            const glm::vec4 corners[3] = {source.position(c.x), source.position(c.y), source.position(c.z)};
            append_triangle(out, corners, i, size, volume);
        } else {
            append_window_triangle(window, c, i, out.triangles);
        }
    }
}

// The tiles that a triangle's box touches.
struct TileRange {
    std::uint16_t left, right, top, bottom, entry;
};

// Sorts a chunk's triangles into the tiles that their boxes touch, and finds the nearest depth.
void sort_into_tiles(const Source& source, const Tiles& tiles, glm::ivec2 size, VisibleChunk& chunk) {
    auto pixels = [](const std::int32_t c[3], int side) {
        const int low = std::min({c[0], c[1], c[2]}), high = std::max({c[0], c[1], c[2]});
        return glm::ivec2(std::max(0, (low + 255) >> 8), std::min(side - 1, high >> 8));
    };
    // Counts are kept two places further on and starts one, so that filling moves each start to where it belongs.
    chunk.large.clear();
    chunk.start.assign(std::size_t(tiles.total()) + 2, 0);
    std::vector<TileRange> ranges;
    ranges.reserve(chunk.screen.triangles.size());
    double nearest = 1;
    const double sign = source.reversed_z ? -1 : 1;
    for (std::size_t k = 0; k < chunk.screen.triangles.size(); ++k) {
        const ScreenTriangle& t = chunk.screen.triangles[k];
        const glm::ivec2 columns = pixels(t.x, size.x), rows = pixels(t.y, size.y);
        if (columns[0] > columns[1] || rows[0] > rows[1]) continue;
        nearest = std::min(nearest, std::min({sign * t.z[0], sign * t.z[1], sign * t.z[2]}));
        const std::uint16_t entry = std::uint16_t(k | (source.is_masked(t.triangle) ? masked : 0));
        const int left = columns[0] >> tiles.shift, right = columns[1] >> tiles.shift;
        const int top = rows[0] >> tiles.shift, bottom = rows[1] >> tiles.shift;
        if ((right - left + 1) * (bottom - top + 1) > few_tiles) {
            chunk.large.push_back(entry);
            continue;
        }
        ranges.push_back({std::uint16_t(left), std::uint16_t(right), std::uint16_t(top), std::uint16_t(bottom), entry});
        for (int y = top; y <= bottom; ++y)
            for (int x = left; x <= right; ++x) ++chunk.start[std::size_t(y * tiles.count.x + x) + 2];
    }
    chunk.nearest = float(nearest - depth_slack);
    for (std::size_t i = 1; i < chunk.start.size(); ++i) chunk.start[i] += chunk.start[i - 1];
    chunk.entries.resize(chunk.start.back());
    for (const TileRange& r : ranges)
        for (int y = r.top; y <= r.bottom; ++y)
            for (int x = r.left; x <= r.right; ++x)
                chunk.entries[chunk.start[std::size_t(y * tiles.count.x + x) + 1]++] = r.entry;
}

// Fills the workspace's chunks with all triangles that may be seen.
void set_up_triangles(const Source& source, const Tiles& tiles, glm::ivec2 size, const RunOptions& options,
                      Workspace& memory) {
    const std::size_t n = source.geometry.triangles.size();
    if (n > max_triangles) throw InputError(fmt::format("raster: {} triangles: expected {} at most", n, max_triangles));
    const std::size_t chunks = (n + chunk_triangles - 1) / chunk_triangles;
    if (memory.chunks.size() < chunks) memory.chunks.resize(chunks);
    const WindowVertex* window = memory.window.reserve(0);
    const CullArgs args{reinterpret_cast<const std::int32_t*>(source.geometry.triangles.data()), window, size};
    dispatch(options.isa, [&](auto isa) {
        parallel_bands(int(n), chunk_triangles, options.threads, [&](int first, int last) {
            VisibleChunk& chunk = memory.chunks[std::size_t(first / chunk_triangles)];
            std::int32_t kept[chunk_triangles];
            const int count = VisibilityKernels<isa()>::cull(args, first, last, kept);
            collect(source, size, window, kept, count, chunk.screen);
            sort_into_tiles(source, tiles, size, chunk);
        });
    });
}

// Draws every tile, and calls resolve(isa, pixels) for it while it is in the caches.
template <class Resolve>
void draw_tiles(const Source& source, const Tiles& tiles, glm::ivec2 size, const RunOptions& options,
                Workspace& memory, float* depth, const float* behind, const Resolve& resolve) {
    std::vector<ChunkView> views;
    const std::size_t chunks = (source.geometry.triangles.size() + chunk_triangles - 1) / chunk_triangles;
    for (std::size_t i = 0; i < chunks; ++i) {
        const VisibleChunk& c = memory.chunks[i];
        if (c.entries.empty() && c.large.empty()) continue;
        views.push_back({c.screen.triangles.data(), c.screen.corners.data(), c.start.data(), c.entries.data(),
                         c.large.data(), std::int32_t(c.large.size()), c.nearest});
    }
    std::vector<std::int32_t> order(views.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::int32_t a, std::int32_t b) { return views[a].nearest < views[b].nearest; });
    const SurfaceArgs surfaces =
        source.surfaces ? surface_args(source.geometry, *source.surfaces, View()) : SurfaceArgs();
    const TileArgs args{views.data(), order.data(), int(views.size()), size, tiles.side(), source.reversed_z, &surfaces,
                        depth, behind};
    dispatch(options.isa, [&](auto isa) {
        parallel_bands(tiles.total(), 1, options, [&](int tile, int) {
            const std::size_t pixels = std::size_t(tiles.side()) * std::size_t(tiles.side());
            Scratch<float> nearest, l1, l2, peeled;
            Scratch<std::int32_t> triangle;
            const glm::ivec2 origin{tile % tiles.count.x * tiles.side(), tile / tiles.count.x * tiles.side()};
            const TilePixels seen{origin, glm::min(size, origin + tiles.side()), tiles.side(), triangle.reserve(pixels),
                                  l1.reserve(pixels), l2.reserve(pixels)};
            VisibilityKernels<isa()>::draw_tile(args, tile, seen, nearest.reserve(pixels),
                                                behind ? peeled.reserve(pixels) : nullptr);
            resolve(isa, seen);
        });
    });
}

template <class Resolve>
void draw(const Source& source, glm::ivec2 size, const RunOptions& options, Workspace* workspace, Image1& depth,
          const Image1* behind, const Resolve& resolve) {
    check_frame_size(size);
    check_behind(behind, size);
    if (depth.width != size.x || depth.height != size.y) depth = Image1(size.x, size.y);
    Workspace fresh;
    Workspace& memory = workspace ? *workspace : fresh;
    const Tiles tiles(size);
    transform_vertices(source, size, options, memory);
    set_up_triangles(source, tiles, size, options, memory);
    draw_tiles(source, tiles, size, options, memory, depth.data(), behind ? behind->data() : nullptr, resolve);
}

void draw(const Source& source, glm::ivec2 size, const RunOptions& options, VisibilityBuffer& out,
          Workspace* workspace, const Image1* behind) {
    check_frame_size(size);
    if (out.triangle.width != size.x || out.triangle.height != size.y)
        out = {Image<std::int32_t>(size.x, size.y), Image1(size.x, size.y), Image<glm::vec2>(size.x, size.y)};
    draw(source, size, options, workspace, out.depth, behind, [&](auto isa, const TilePixels& seen) {
        VisibilityKernels<isa()>::write_rows(seen, size.x, out.triangle.data(), &out.barycentrics.data()->x);
    });
}

}  // namespace

void check_frame_size(glm::ivec2 size) {
    if (size.x < 1 || size.y < 1 || size.x > max_frame_side || size.y > max_frame_side)
        throw InputError(fmt::format("raster: size = {} x {}: expected 1 to {} pixels a side", size.x, size.y,
                                     max_frame_side));
}

void check_behind(const Image1* behind, glm::ivec2 size) {
    if (behind && (behind->width != size.x || behind->height != size.y))
        throw InputError(fmt::format("raster: behind = {} x {}: expected {} x {} pixels, the frame's", behind->width,
                                     behind->height, size.x, size.y));
}

void draw_visibility(const Geometry& geometry, const Surfaces* surfaces, const View& view, glm::ivec2 size,
                     const RunOptions& options, VisibilityBuffer& out, Workspace* workspace, const Image1* behind) {
    draw({geometry, surfaces, view.world_to_clip(), nullptr, view.reversed_z}, size, options, out, workspace, behind);
}

void draw_visibility(const Geometry& geometry, const Surfaces* surfaces, const Buffer<glm::vec4>& clip_positions,
                     bool reversed_z, glm::ivec2 size, const RunOptions& options, VisibilityBuffer& out,
                     Workspace* workspace, const Image1* behind) {
    draw({geometry, surfaces, glm::dmat4(1), &clip_positions, reversed_z}, size, options, out, workspace, behind);
}

void draw_visible_tiles(const Geometry& geometry, const Surfaces* surfaces, const View& view, glm::ivec2 size,
                        const RunOptions& options, Image1& depth, Workspace* workspace,
                        const std::function<void(const TilePixels&)>& resolve, const Image1* behind) {
    draw({geometry, surfaces, view.world_to_clip(), nullptr, view.reversed_z}, size, options, workspace, depth, behind,
         [&](auto, const TilePixels& seen) { resolve(seen); });
}

void draw_visible_tiles(const Geometry& geometry, const Surfaces* surfaces, const Buffer<glm::vec4>& clip_positions,
                        bool reversed_z, glm::ivec2 size, const RunOptions& options, Image1& depth,
                        Workspace* workspace, const std::function<void(const TilePixels&)>& resolve,
                        const Image1* behind) {
    draw({geometry, surfaces, glm::dmat4(1), &clip_positions, reversed_z}, size, options, workspace, depth, behind,
         [&](auto, const TilePixels& seen) { resolve(seen); });
}

VisibilityBuffer draw_visibility(const Geometry& geometry, const View& view, glm::ivec2 size,
                                 const RunOptions& options) {
    VisibilityBuffer out;
    draw_visibility(geometry, nullptr, view, size, options, out);
    return out;
}

VisibilityBuffer draw_visibility_rows(const Geometry& geometry, const View& view, glm::ivec2 size, int first, int last,
                                      const RunOptions& options) {
    return reference_visibility(geometry, nullptr, view, size, first, last, options);
}

VisibilityBuffer draw_visibility_rows(const Geometry& geometry, const Surfaces* surfaces, const View& view,
                                      glm::ivec2 size, int first, int last, const RunOptions& options,
                                      const Image1* behind) {
    return reference_visibility(geometry, surfaces, view, size, first, last, options, behind);
}

}  // namespace plumb::raster
