// A stage's buffers as pictures for people: what an input or output holds, brought into 0..1, and how, in words.
#pragma once

#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "core/binding.h"
#include "core/image.h"

namespace plumb::cli {

struct SlotPicture {
    Image<std::uint32_t> texels;  // RGBA8, sRGB
    std::string name;             // with unit and meaning
    std::string mapping;          // what black and white stand for, least and largest value
};

// The layers of an image or of an array of images; none of a buffer.
int layers_of(const Slot& slot, const Array& array);
glm::ivec2 layer_size(const Slot& slot, const Array& array);

// What is no number is magenta, and counted in words.
SlotPicture slot_picture(const Slot& slot, const Array& array, int layer);
// With the colours of another array of the same slot, so that both can be held against each other.
SlotPicture slot_picture_like(const Slot& slot, const Array& array, const Array& like, int layer);

// By how much a picture has to be kept smaller so that no side is above `most` texels; and it, as means of by x by texels.
int reduction(const Image<std::uint32_t>& image, int most);
Image<std::uint32_t> reduced(const Image<std::uint32_t>& image, int by);
// The texels of [first, first + size); black outside.
Image<std::uint32_t> crop(const Image<std::uint32_t>& image, glm::ivec2 first, glm::ivec2 size);

// A buffer in words: "weights (texels): [400] f32, 0.1 to 3.2; texels that a sample stands for".
std::string buffer_text(const Slot& slot, const Array& array);

}  // namespace plumb::cli
