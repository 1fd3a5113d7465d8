// Memory that passes keep from one frame to the next: a frame like the last one then allocates nothing, and no page of
// it is touched for the first time. What it holds never changes a result.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "raster/visibility.h"
#include "raster/visibility_kernel.h"

namespace plumb::raster {

// An array that is not initialised: the threads that fill it are the first to touch its pages.
template <class T>
class Scratch {
  public:
    T* reserve(std::size_t n) {
        if (n > capacity_) values_ = std::make_unique_for_overwrite<T[]>(capacity_ = n);
        return values_.get();
    }

  private:
    std::unique_ptr<T[]> values_;
    std::size_t capacity_ = 0;
};

// What becomes of chunk_triangles triangles: those that may be seen, and which tiles they touch. See ChunkView.
struct VisibleChunk {
    ScreenTriangles screen;
    std::vector<std::uint32_t> start;
    std::vector<std::uint16_t> entries, large;
    float nearest = 0;
};

struct Workspace {
    Scratch<WindowVertex> window;
    std::vector<VisibleChunk> chunks;
    Image1 depth;  // of a pass that does not give it away
};

}  // namespace plumb::raster
