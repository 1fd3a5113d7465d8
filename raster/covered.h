// Which parts of a frame see a surface, in squares small enough to be worth asking and large enough to be cheap.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>

#include "core/image.h"

namespace plumb::raster {

// A byte for each square of 16 x 16 pixels of a frame; those at the right and the bottom border may be cut.
struct Covered {
    static constexpr int shift = 4, side = 1 << shift;  // pixels
    glm::ivec2 tiles{0};
    Buffer<std::uint8_t> any;  // [tiles.y][tiles.x]: 1 where some pixel sees a surface

    Covered() = default;
    explicit Covered(glm::ivec2 size, std::uint8_t fill = 0)
        : tiles((size + (side - 1)) >> shift), any(std::size_t(tiles.x) * std::size_t(tiles.y), fill) {}

    bool fits(glm::ivec2 size) const { return tiles == ((size + (side - 1)) >> shift); }
    // The row of tiles that row y of pixels lies in.
    const std::uint8_t* row(int y) const { return any.data() + std::ptrdiff_t(y >> shift) * tiles.x; }
};

}  // namespace plumb::raster
