#include "tools/vulkan/batches.h"

#include <cstring>

#include "core/error.h"

namespace plumb::vulkan {

Batches split_draw(std::span<const std::int32_t> triangles, std::size_t vertices, std::size_t most_vertices) {
    Batches out;
    const std::size_t n = triangles.size() / 3;
    if (vertices <= most_vertices) {
        out.list.push_back({0, std::uint32_t(n), {}});
        return out;
    }
    std::vector<std::int32_t> place(vertices, -1);  // in the batch at hand
    out.triangles.reserve(3 * n);
    for (std::size_t t = 0; t < n; ++t) {
        if (out.list.empty() || out.list.back().vertices.size() + 3 > most_vertices) {
            if (!out.list.empty())
                for (std::int32_t v : out.list.back().vertices) place[std::size_t(v)] = -1;
            out.list.push_back({std::uint32_t(t), 0, {}});
        }
        Batch& batch = out.list.back();
        ++batch.count;
        for (std::size_t corner = 0; corner < 3; ++corner) {
            const std::int32_t v = triangles[3 * t + corner];
            if (v < 0 || std::size_t(v) >= vertices) throw InputError("triangles: an index out of range");
            if (place[std::size_t(v)] < 0) {
                place[std::size_t(v)] = std::int32_t(batch.vertices.size());
                batch.vertices.push_back(v);
            }
            out.triangles.push_back(place[std::size_t(v)]);
        }
    }
    return out;
}

Buffer<unsigned char> gather_rows(const Array& array, const std::vector<std::int32_t>& rows) {
    const std::size_t row = array.bytes.size() / std::size_t(array.shape[0]);
    Buffer<unsigned char> out(rows.size() * row);
    for (std::size_t i = 0; i < rows.size(); ++i)
        std::memcpy(out.data() + i * row, array.bytes.data() + std::size_t(rows[i]) * row, row);
    return out;
}

}  // namespace plumb::vulkan
