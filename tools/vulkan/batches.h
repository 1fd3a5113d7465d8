// A draw whose vertices do not fit into a device's largest buffer, in several: each has vertices of its own, and the
// numbers of triangles stay those of the whole.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/bundle.h"

namespace plumb::vulkan {

struct Batch {
    std::uint32_t first = 0, count = 0;  // of triangles
    std::vector<std::int32_t> vertices;  // of the whole, in the order in which the batch has them; empty: all of them
};

struct Batches {
    std::vector<Batch> list;
    std::vector<std::int32_t> triangles;  // [triangle][3]: indices into the vertices of its batch; empty: as they were
};

// One batch of all where there are no more than most_vertices. Throws InputError for an index out of range.
Batches split_draw(std::span<const std::int32_t> triangles, std::size_t vertices, std::size_t most_vertices);

// The rows of an array [vertex][...] that a batch has.
Buffer<unsigned char> gather_rows(const Array& array, const std::vector<std::int32_t>& rows);

}  // namespace plumb::vulkan
