// How the bytes of a stage's input lie: layers of rows of texels.
#pragma once

#include <cstddef>

#include "gi/parity/hypothesis.h"

namespace plumb::parity {

// An input of floats as layers of rows of texels; a buffer is one row.
struct Texels {
    std::size_t layers = 1, height = 1, width = 1, channels = 1;

    std::size_t count() const { return layers * height * width; }
    std::size_t at(std::size_t layer, std::size_t y, std::size_t x) const {
        return ((layer * height + y) * width + x) * channels;
    }
};

inline Texels texels_of(const Slot& slot, const Array& array) {
    Texels t;
    t.channels = slot.kind == SlotKind::image_array ? 1 : std::size_t(slot.channels);
    const Shape& s = array.shape;
    if (slot.kind == SlotKind::buffer) {
        t.width = array.bytes.size() / 4 / t.channels;
    } else {
        const std::size_t first = slot.kind == SlotKind::image_array ? 1 : 0;
        if (first) t.layers = std::size_t(s[0]);
        t.height = std::size_t(s[first]), t.width = std::size_t(s[first + 1]);
    }
    return t;
}

}  // namespace plumb::parity
