// Bundles: named arrays of numbers, the plain data that stages are bound to and that io/ writes to files.
//
// An array is row-major, its last extent varies fastest: a picture is [height, width, channels], first row on top.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/content_hash.h"
#include "core/image.h"
#include "core/number.h"

namespace plumb {

enum class DType : int { f32, f64, u8, u16, i32, u32, f16 };

const char* dtype_name(DType dtype);
std::size_t dtype_size(DType dtype);  // bytes
// Throws InputError at `place` for an unknown name.
DType parse_dtype(const std::string& name, const std::string& place);

template <class T>
inline constexpr DType dtype_of = [] { static_assert(sizeof(T) == 0, "no dtype for this type"); }();
template <>
inline constexpr DType dtype_of<float> = DType::f32;
template <>
inline constexpr DType dtype_of<double> = DType::f64;
template <>
inline constexpr DType dtype_of<std::uint8_t> = DType::u8;
template <>
inline constexpr DType dtype_of<std::uint16_t> = DType::u16;
template <>
inline constexpr DType dtype_of<std::int32_t> = DType::i32;
template <>
inline constexpr DType dtype_of<std::uint32_t> = DType::u32;
template <>
inline constexpr DType dtype_of<Half> = DType::f16;

using Shape = std::vector<std::int64_t>;
inline constexpr std::int64_t any_extent = -1;  // in an expected shape: whatever the array has

std::string shape_text(const Shape& shape);  // "[512, 512, 4]", any_extent as "*"
// Product of the extents; throws InputError naming the array if one is negative or the product overflows.
std::size_t element_count(const std::string& name, const Shape& shape);

struct Array {
    std::string name;
    DType dtype = DType::f32;
    Shape shape;
    Buffer<unsigned char> bytes;  // element_count * dtype_size of them
};

struct Bundle {
    std::vector<Array> arrays;  // in the order in which they were added
};

// Appends an array of zeros; throws InputError if the name is taken.
Array& add(Bundle& bundle, const std::string& name, DType dtype, const Shape& shape);
// The array of that name, or null.
const Array* find(const Bundle& bundle, const std::string& name);
// The same, or InputError that lists the names there are.
const Array& at(const Bundle& bundle, const std::string& name);

// Throws InputError that names the array, what was expected and what is there.
void require(const Array& array, DType dtype, const Shape& expected);

// Typed access to all elements.
template <class T>
std::span<const T> elements(const Array& array, const Shape& expected) {
    require(array, dtype_of<T>, expected);
    return {reinterpret_cast<const T*>(array.bytes.data()), array.bytes.size() / sizeof(T)};
}
template <class T>
std::span<T> elements(Array& array, const Shape& expected) {
    require(array, dtype_of<T>, expected);
    return {reinterpret_cast<T*>(array.bytes.data()), array.bytes.size() / sizeof(T)};
}
template <class T>
std::span<const T> elements(const Bundle& bundle, const std::string& name, const Shape& expected) {
    return elements<T>(at(bundle, name), expected);
}
template <class T>
Array& add(Bundle& bundle, const std::string& name, const Shape& shape, const T* data) {
    Array& array = add(bundle, name, dtype_of<T>, shape);
    if (!array.bytes.empty()) std::memcpy(array.bytes.data(), data, array.bytes.size());
    return array;
}

// Pictures of floats: [height, width, 4] and [height, width].
Array& add(Bundle& bundle, const std::string& name, const Image4& image);
Array& add(Bundle& bundle, const std::string& name, const Image1& image);
Image4 image4(const Array& array);
Image1 image1(const Array& array);

// Of names, types, shapes and bytes, in order.
std::uint64_t content_hash(const Array& array, std::uint64_t seed = 0);
std::uint64_t content_hash(const Bundle& bundle, std::uint64_t seed = 0);

}  // namespace plumb
