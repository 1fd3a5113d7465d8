// Where the items of a data texture lie. Private to textures*.cpp.
#pragma once

#include "gi/probes/textures.h"

namespace plumb::probes {

// In the order of textures().
enum class TextureId : int {
    probe_rays,
    spherical_harmonics,
    cluster_matrix,
    cluster_size,
    cluster_probes,
    receiver_map,
    receiver_transport,
    receiver_material,
    probe_position,
    hit_position,
    receiver_position,
    cluster_bounds,
};
inline constexpr int texture_count = 12;
inline const TextureInfo& info_of(TextureId id) { return textures()[std::size_t(id)]; }
// Throws InputError for a name that there is not.
TextureId texture_id(const std::string& name);

// All that the sizes of textures follow from.
struct TextureCounts {
    std::int64_t receivers = 0, probes = 0, clusters = 0, rays = 0, coefficients = 0, singular_values = 0;
    std::int64_t cluster_probes = 1;  // of the largest cluster, at least 1
    std::int64_t cluster_columns = 1, receiver_columns = 1;
};
TextureCounts counts_of(const BakeArrays& arrays, const TextureLayout& layout);

struct ItemGrid {
    std::int64_t items, columns, width, height;  // width x height texels an item

    std::int64_t rows() const { return (items + columns - 1) / columns; }
    Shape shape(int channels) const { return {rows() * height, columns * width, channels}; }
    // The index of texel (x, y) of an item in its texture.
    std::size_t texel(std::int64_t item, std::int64_t x, std::int64_t y) const {
        const std::int64_t row = item / columns * height + y, column = item % columns * width + x;
        return std::size_t(row * columns * width + column);
    }
};
ItemGrid grid_of(TextureId id, const TextureCounts& counts);

// Throws InputError unless the arrays are those of a bake.
void check(const BakeArrays& arrays);

}  // namespace plumb::probes
