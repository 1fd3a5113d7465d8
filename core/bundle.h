// Bundles: named arrays of numbers, the plain data that stages are bound to and that io/ writes to files.
//
// An array is row-major, its last extent varies fastest: a picture is [height, width, channels], first row on top.
#pragma once

#include <cstdint>
#include <cstring>
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

// The bytes of an array: its own, or lent by an image or a buffer that must outlive them. What is lent to be read is
// copied when somebody writes to it; what is lent to be written takes what is written.
class Bytes {
  public:
    Bytes() = default;
    explicit Bytes(std::size_t n) : own_(n) {}
    static Bytes lent(const void* data, std::size_t n) { return Bytes(data, n, false); }
    static Bytes lent_to_write(void* data, std::size_t n) { return Bytes(data, n, true); }

    std::size_t size() const { return lent_ ? size_ : own_.size(); }
    bool empty() const { return size() == 0; }
    const unsigned char* data() const { return lent_ ? lent_ : own_.data(); }
    unsigned char* data() {
        if (lent_ && !writable_) own();
        return lent_ ? const_cast<unsigned char*>(lent_) : own_.data();
    }
    const unsigned char* begin() const { return data(); }
    const unsigned char* end() const { return data() + size(); }
    unsigned char* begin() { return data(); }
    unsigned char* end() { return data() + size(); }
    unsigned char operator[](std::size_t i) const { return data()[i]; }
    unsigned char& operator[](std::size_t i) { return data()[i]; }
    void resize(std::size_t n) {
        own();
        own_.resize(n);
    }
    void pop_back() { resize(size() - 1); }
    // Copies what is lent.
    void own() {
        if (!lent_) return;
        own_.assign(lent_, lent_ + size_);
        lent_ = nullptr;
    }
    friend bool operator==(const Bytes& a, const Bytes& b) {
        return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size()) == 0);
    }

  private:
    Bytes(const void* data, std::size_t n, bool writable)
        : lent_(static_cast<const unsigned char*>(data)), size_(n), writable_(writable) {}

    Buffer<unsigned char> own_;
    const unsigned char* lent_ = nullptr;
    std::size_t size_ = 0;  // of what is lent
    bool writable_ = false;
};

struct Array {
    std::string name;
    DType dtype = DType::f32;
    Shape shape;
    Bytes bytes;  // element_count * dtype_size of them
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

// Appends an array that reads, or writes, where `data` points.
template <class T>
Array& lend(Bundle& bundle, const std::string& name, const Shape& shape, T* data) {
    using Value = std::remove_const_t<T>;
    Array& array = add(bundle, name, dtype_of<Value>, {0});
    const std::size_t n = element_count(name, shape) * sizeof(Value);
    array.shape = shape;
    if constexpr (std::is_const_v<T>)
        array.bytes = Bytes::lent(data, n);
    else
        array.bytes = Bytes::lent_to_write(data, n);
    return array;
}
Array& lend(Bundle& bundle, const std::string& name, const Image4& image);
Array& lend(Bundle& bundle, const std::string& name, const Image1& image);
Array& lend_to_write(Bundle& bundle, const std::string& name, Image4& image);

// Pictures of floats: [height, width, 4] and [height, width].
Array& add(Bundle& bundle, const std::string& name, const Image4& image);
Array& add(Bundle& bundle, const std::string& name, const Image1& image);
Image4 image4(const Array& array);
Image1 image1(const Array& array);

// Of names, types, shapes and bytes, in order.
std::uint64_t content_hash(const Array& array, std::uint64_t seed = 0);
std::uint64_t content_hash(const Bundle& bundle, std::uint64_t seed = 0);

}  // namespace plumb
