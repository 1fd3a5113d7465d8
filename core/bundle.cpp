#include "core/bundle.h"

#include <limits>

#include "core/error.h"

namespace plumb {
namespace {

struct DTypeInfo {
    const char* name;
    std::size_t size;
};
constexpr DTypeInfo dtypes[] = {{"f32", 4}, {"f64", 8}, {"u8", 1}, {"u16", 2}, {"i32", 4}, {"u32", 4}, {"f16", 2}};

std::string quoted(const std::string& name) { return "array \"" + name + "\""; }

bool matches(const Shape& shape, const Shape& expected) {
    if (shape.size() != expected.size()) return false;
    for (std::size_t i = 0; i < shape.size(); ++i)
        if (expected[i] != any_extent && expected[i] != shape[i]) return false;
    return true;
}

template <class T>
Image<T> image_of(const Array& array, const Shape& expected) {
    const std::span<const float> values = elements<float>(array, expected);
    constexpr std::int64_t largest = std::numeric_limits<int>::max();
    if (array.shape[0] > largest || array.shape[1] > largest)
        throw InputError(quoted(array.name) + ": " + shape_text(array.shape) + " is too large for a picture");
    Image<T> image(int(array.shape[1]), int(array.shape[0]));
    if (!values.empty()) std::memcpy(image.data(), values.data(), values.size_bytes());
    return image;
}

}  // namespace

const char* dtype_name(DType dtype) { return dtypes[int(dtype)].name; }
std::size_t dtype_size(DType dtype) { return dtypes[int(dtype)].size; }

DType parse_dtype(const std::string& name, const std::string& place) {
    std::string known;
    for (int i = 0; i < int(std::size(dtypes)); ++i) {
        if (name == dtypes[i].name) return DType(i);
        known += (i ? ", " : "") + std::string(dtypes[i].name);
    }
    throw InputError(place + ": type \"" + name + "\" is unknown; expected one of " + known);
}

std::string shape_text(const Shape& shape) {
    std::string text = "[";
    for (std::size_t i = 0; i < shape.size(); ++i)
        text += (i ? ", " : "") + (shape[i] == any_extent ? "*" : std::to_string(shape[i]));
    return text + "]";
}

std::size_t element_count(const std::string& name, const Shape& shape) {
    // Leaves room for elements of 8 bytes, so that the size in bytes cannot overflow either.
    constexpr std::int64_t limit = std::numeric_limits<std::int64_t>::max() / 8;
    std::int64_t count = 1;
    for (std::int64_t extent : shape) {
        if (extent < 0) throw InputError(quoted(name) + ": shape " + shape_text(shape) + " has a negative extent");
        if (extent != 0 && count > limit / extent)
            throw InputError(quoted(name) + ": shape " + shape_text(shape) + " has too many elements");
        count *= extent;
    }
    return std::size_t(count);
}

Array& add(Bundle& bundle, const std::string& name, DType dtype, const Shape& shape) {
    if (find(bundle, name)) throw InputError(quoted(name) + " is there already");
    const std::size_t size = element_count(name, shape) * dtype_size(dtype);
    return bundle.arrays.emplace_back(Array{name, dtype, shape, Bytes(size)});
}

const Array* find(const Bundle& bundle, const std::string& name) {
    for (const Array& array : bundle.arrays)
        if (array.name == name) return &array;
    return nullptr;
}

const Array& at(const Bundle& bundle, const std::string& name) {
    if (const Array* array = find(bundle, name)) return *array;
    std::string known;
    for (const Array& array : bundle.arrays) known += (known.empty() ? "" : ", ") + array.name;
    throw InputError(quoted(name) + " is missing; there are: " + (known.empty() ? "none" : known));
}

void require(const Array& array, DType dtype, const Shape& expected) {
    if (array.dtype != dtype || !matches(array.shape, expected))
        throw InputError(quoted(array.name) + ": expected " + dtype_name(dtype) + " " + shape_text(expected) +
                         ", got " + dtype_name(array.dtype) + " " + shape_text(array.shape));
    const std::size_t size = element_count(array.name, array.shape) * dtype_size(dtype);
    if (array.bytes.size() != size)
        throw InputError(quoted(array.name) + ": expected " + std::to_string(size) + " bytes, got " +
                         std::to_string(array.bytes.size()));
}

Array& lend(Bundle& bundle, const std::string& name, const Image4& image) {
    return lend(bundle, name, {image.height, image.width, 4}, image.empty() ? nullptr : &image.data()->x);
}
Array& lend(Bundle& bundle, const std::string& name, const Image1& image) {
    return lend(bundle, name, {image.height, image.width}, image.data());
}
Array& lend_to_write(Bundle& bundle, const std::string& name, Image4& image) {
    return lend(bundle, name, {image.height, image.width, 4}, image.empty() ? nullptr : &image.data()->x);
}

Array& add(Bundle& bundle, const std::string& name, const Image4& image) {
    return add(bundle, name, {image.height, image.width, 4}, reinterpret_cast<const float*>(image.data()));
}
Array& add(Bundle& bundle, const std::string& name, const Image1& image) {
    return add(bundle, name, {image.height, image.width}, image.data());
}
Image4 image4(const Array& array) { return image_of<glm::vec4>(array, {any_extent, any_extent, 4}); }
Image1 image1(const Array& array) { return image_of<float>(array, {any_extent, any_extent}); }

std::uint64_t content_hash(const Array& array, std::uint64_t seed) {
    std::uint64_t hash = content_hash(array.name, seed);
    hash = content_hash(std::string(dtype_name(array.dtype)), hash);
    hash = content_hash(array.shape.data(), array.shape.size() * sizeof(array.shape[0]), hash);
    return content_hash(array.bytes.data(), array.bytes.size(), hash);
}

std::uint64_t content_hash(const Bundle& bundle, std::uint64_t seed) {
    for (const Array& array : bundle.arrays) seed = content_hash(array, seed);
    return seed;
}

}  // namespace plumb
