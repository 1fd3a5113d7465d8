#include "tools/plumb/slot_array.h"

#include <fmt/format.h>

#include <cmath>
#include <cstring>

#include "core/error.h"

namespace plumb::cli {

namespace {

template <class T>
double element(const Array& array, std::size_t i) {
    T value;
    std::memcpy(&value, array.bytes.data() + i * sizeof(T), sizeof(T));
    return double(value);
}

double element(const Array& array, std::size_t i) {
    switch (array.dtype) {
        case DType::f32: return element<float>(array, i);
        case DType::f64: return element<double>(array, i);
        case DType::u8: return element<std::uint8_t>(array, i);
        case DType::u16: return element<std::uint16_t>(array, i);
        case DType::i32: return element<std::int32_t>(array, i);
        case DType::u32: return element<std::uint32_t>(array, i);
        case DType::f16: {
            Half half;
            std::memcpy(&half, array.bytes.data() + i * sizeof half, sizeof half);
            return half_to_float(half);
        }
    }
    return 0;
}

bool same_bits(DType a, DType b) {
    const bool integers = (a == DType::i32 || a == DType::u32) && (b == DType::i32 || b == DType::u32);
    return a == b || integers;
}

// The number as the slot's type holds it. Indices that were dumped as floats are whole.
void store(double value, DType dtype, unsigned char* out, const std::string& place) {
    const float f = float(value);
    const std::uint32_t bits = dtype == DType::u32 ? std::uint32_t(std::int64_t(value)) : std::uint32_t(std::int32_t(value));
    if (dtype != DType::f32) {
        const double low = dtype == DType::u32 ? 0 : -0x1p31, high = dtype == DType::u32 ? 0x1p32 : 0x1p31;
        if (!(value == std::floor(value) && value >= low && value < high))
            throw InputError(fmt::format("{}: holds {}: expected whole numbers of 32 bits", place, value));
    }
    std::memcpy(out, dtype == DType::f32 ? static_cast<const void*>(&f) : &bits, 4);
}

// `pixels` texels of `from` channels each, as texels of slot.channels.
void convert(Array& array, const Slot& slot, std::size_t pixels, std::size_t from, const std::string& place) {
    const std::size_t to = std::size_t(slot.channels), kept = std::min(from, to);
    if (from == to && same_bits(array.dtype, slot.dtype)) {
        array.dtype = slot.dtype;
        return;
    }
    Array out{array.name, slot.dtype, array.shape, {}};
    out.bytes.resize(pixels * to * 4);
    const bool copies = same_bits(array.dtype, slot.dtype);
    for (std::size_t p = 0; p < pixels; ++p) {
        unsigned char* texel = out.bytes.data() + p * to * 4;
        if (copies)
            std::memcpy(texel, array.bytes.data() + p * from * 4, kept * 4);
        else
            for (std::size_t c = 0; c < kept; ++c) store(element(array, p * from + c), slot.dtype, texel + 4 * c, place);
    }
    array = std::move(out);
}

std::size_t channels_of(const Array& array) { return array.shape.size() == 3 ? std::size_t(array.shape[2]) : 1; }

std::string size_text(glm::ivec2 size) { return fmt::format("{} x {}", size.x, size.y); }

// "xyz" of the bits 0 to 2.
std::string letters(unsigned channels) {
    std::string text;
    for (int c = 0; c < 4; ++c)
        if (channels >> c & 1) text += "xyzw"[c];
    return text;
}

// Whether a surface is there: 1 where the normal is not 0. What no fourth channel says.
void mark_surfaces(Array& normals) {
    auto* texels = reinterpret_cast<float*>(normals.bytes.data());
    for (std::size_t i = 0; i < normals.bytes.size() / sizeof(float); i += 4)
        texels[i + 3] = texels[i] != 0 || texels[i + 1] != 0 || texels[i + 2] != 0 ? 1.0f : 0.0f;
}

// What an input lacks: x, y and z are never guessed.
void complete(const Slot& slot, unsigned dumped, Array& array, const std::string& place,
              std::vector<std::string>& notes) {
    const unsigned missing = ((1u << slot.channels) - 1) & ~dumped;
    if (missing == 0) return;
    if (missing != 8 || slot.dtype != DType::f32)
        throw InputError(fmt::format("{}: has the channels \"{}\": the stage reads \"{}\"", place, letters(dumped),
                                     letters(((1u << slot.channels) - 1) & 7u)));
    if (slot.name.ends_with("normal")) {
        mark_surfaces(array);
        notes.push_back(slot.name + ": w was not dumped; it is 1 where the normal is not 0");
    } else {
        auto* texels = reinterpret_cast<float*>(array.bytes.data());
        for (std::size_t i = 3; i < array.bytes.size() / sizeof(float); i += 4) texels[i] = 0;
        notes.push_back(slot.name + ": w was not dumped; it is taken as 0");
    }
}

}  // namespace

void replace(Bundle& bundle, Array array) {
    std::erase_if(bundle.arrays, [&](const Array& a) { return a.name == array.name; });
    bundle.arrays.push_back(std::move(array));
}

std::vector<double> numbers(const Array& array, const std::string& place) {
    std::vector<double> values(element_count(place, array.shape));
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = element(array, i);
    return values;
}

glm::ivec2 image_size(const Array& array, const std::string& place) {
    if (array.shape.size() != 2 && array.shape.size() != 3)
        throw InputError(fmt::format("{}: is {}: expected [height, width] or [height, width, channels]", place,
                                     shape_text(array.shape)));
    for (std::int64_t extent : array.shape)
        if (extent < 1 || extent > 1 << 30)
            throw InputError(fmt::format("{}: is {}: expected extents of at least 1", place, shape_text(array.shape)));
    return {int(array.shape[1]), int(array.shape[0])};
}

Array input_array(const Slot& slot, io::DumpedImage dump, glm::ivec2 size, const std::string& place,
                  std::vector<std::string>& notes) {
    Array& array = dump.array;
    array.name = slot.name;
    if (slot.kind == SlotKind::buffer) {
        Slot number = slot;
        number.channels = 1;
        convert(array, number, element_count(place, array.shape), 1, place);
        if (array.shape.size() > 1 && array.shape.back() == 1) array.shape.pop_back();
        return std::move(array);
    }
    if (slot.kind == SlotKind::image_array) {
        if (array.shape.size() == 3 && array.shape[1] == size.y && array.shape[2] == size.x && array.shape[2] > 4)
            array.shape = {array.shape[0] * array.shape[1], array.shape[2]};
        const glm::ivec2 all = image_size(array, place);
        if (all.x != size.x || all.y % size.y != 0)
            throw InputError(fmt::format("{}: is {}: expected layers of {}, one below the other", place, size_text(all),
                                         size_text(size)));
        convert(array, slot, std::size_t(all.x) * std::size_t(all.y), channels_of(array), place);
        array.shape = {all.y / size.y, size.y, size.x};
        return std::move(array);
    }
    const glm::ivec2 found = image_size(array, place);
    if (slot.frame && found != size)
        throw InputError(
            fmt::format("{}: is {}: the stage's outputs are {}", place, size_text(found), size_text(size)));
    convert(array, slot, std::size_t(found.x) * std::size_t(found.y), channels_of(array), place);
    array.shape = {found.y, found.x};
    if (slot.channels > 1) array.shape.push_back(slot.channels);
    complete(slot, dump.channels, array, place, notes);
    return std::move(array);
}

void fit_output(const Slot& slot, io::DumpedImage& dump, glm::ivec2 size, const std::string& place) {
    const glm::ivec2 found = image_size(dump.array, place);
    if (found != size)
        throw InputError(
            fmt::format("{}: is {}: the stage's outputs are {}", place, size_text(found), size_text(size)));
    // How far each number was moved lies beside it, in the same shape; indices were not.
    if (slot.dtype != DType::f32) dump.rounding = {};
    for (Array* array : {&dump.array, &dump.rounding}) {
        if (array->bytes.empty()) continue;
        array->name = slot.name;
        convert(*array, slot, std::size_t(found.x) * std::size_t(found.y), channels_of(*array), place);
        array->shape = {found.y, found.x};
        if (slot.channels > 1) array->shape.push_back(slot.channels);
    }
}

}  // namespace plumb::cli
