// glTF's accessors: arrays of numbers in buffers, strided, normalised, sparse. glTF 2.0, 3.6.2.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "io/gltf_document.h"

namespace plumb::io {
namespace {

enum Component : int { i8 = 5120, u8 = 5121, i16 = 5122, u16 = 5123, u32 = 5125, f32 = 5126 };

std::size_t size_of(int component) { return component <= u8 ? 1 : component <= u16 ? 2 : 4; }

// Little-endian numbers of any alignment.
template <class T>
T load(const unsigned char* p) {
    T value;
    std::memcpy(&value, p, sizeof value);
    return value;
}

std::uint32_t load_integer(const unsigned char* p, int component) {
    return component == u8 ? *p : component == u16 ? load<std::uint16_t>(p) : load<std::uint32_t>(p);
}

// glTF 2.0, 3.11: f = c / (2^n - 1) for unsigned integers of n bits, max(c / (2^(n - 1) - 1), -1) for signed ones.
float load_float(const unsigned char* p, int component, bool normalised) {
    const auto part = [&](float c, float whole) { return normalised ? std::max(c / whole, -1.0f) : c; };
    switch (component) {
        case i8:
            return part(float(load<std::int8_t>(p)), 127.0f);
        case u8:
            return part(float(*p), 255.0f);
        case i16:
            return part(float(load<std::int16_t>(p)), 32767.0f);
        case u16:
            return part(float(load<std::uint16_t>(p)), 65535.0f);
        default:
            return load<float>(p);
    }
}

struct Accessor {
    JsonValue json;
    int component = 0, components = 1;
    std::size_t count = 0, stride = 0;
    const unsigned char* data = nullptr;  // null: zeros

    std::size_t element_bytes() const { return size_of(component) * std::size_t(components); }
};

JsonValue find_accessor(const GltfDocument& document, const JsonValue& index) {
    const JsonValue accessors = document.list("accessors");
    return accessors[*index.required().index(accessors.size(), "accessors")];
}

// Where `count` elements lie in a view from `offset` on; none may end beyond the view.
const unsigned char* place(const JsonValue& json, ByteSpan view, std::uint64_t offset, std::size_t count,
                           std::size_t stride, std::size_t element_bytes) {
    // count is at most 2^28 and the stride 252: nothing overflows.
    const std::uint64_t end = offset + std::uint64_t(count - 1) * stride + element_bytes;
    if (end > view.size)
        json.fail(fmt::format("{} elements end at byte {} of a bufferView of {}", count, end, view.size));
    return view.data + offset;
}

Accessor open_accessor(const GltfDocument& document, const JsonValue& index) {
    Accessor a{find_accessor(document, index)};
    a.component = int(a.json["componentType"].integer(0, 65535));
    if (a.component < i8 || a.component > f32 || a.component == 5124)
        a.json["componentType"].fail("expected one of 5120, 5121, 5122, 5123, 5125, 5126");
    const std::string type = a.json["type"].text();
    if (type == "SCALAR" || type == "VEC2" || type == "VEC3" || type == "VEC4")
        a.components = type == "SCALAR" ? 1 : type[3] - '0';
    else if (type == "MAT4")
        a.components = 16;
    else
        a.json["type"].fail("expected SCALAR, VEC2, VEC3, VEC4 or MAT4");
    a.count = std::size_t(a.json["count"].integer(1, max_gltf_elements));
    a.stride = a.element_bytes();

    const JsonValue view_index = a.json["bufferView"];
    const std::uint64_t offset = a.json["byteOffset"].integer(0, std::uint64_t(1) << 40, 0);
    if (!view_index) {
        document.count_zeros(a.count, a.json["count"]);
        return a;
    }
    const ByteSpan view = view_bytes(document, view_index);
    const JsonValue stride = document.list("bufferViews")[std::size_t(view_index.integer(0, ~0u))]["byteStride"];
    if (stride) {
        a.stride = std::size_t(stride.integer(4, 252));
        if (a.stride % 4 != 0) stride.fail("expected a multiple of 4");
        if (a.stride < a.element_bytes()) stride.fail(fmt::format("an element has {} bytes", a.element_bytes()));
    }
    a.data = place(a.json, view, offset, a.count, a.stride, a.element_bytes());
    return a;
}

// Calls put(element, bytes) for each element that the accessor's sparse part replaces.
template <class Put>
void replace_sparse(const GltfDocument& document, const Accessor& a, Put put) {
    const JsonValue sparse = a.json["sparse"];
    if (!sparse) return;
    const std::size_t count = std::size_t(sparse["count"].integer(1, a.count));
    const JsonValue indices = sparse["indices"].required(), values = sparse["values"].required();
    const int component = int(indices["componentType"].integer(0, 65535));
    if (component != u8 && component != u16 && component != u32)
        indices["componentType"].fail("expected one of 5121, 5123, 5125");
    const std::uint64_t limit = std::uint64_t(1) << 40;
    const unsigned char* index =
        place(indices, view_bytes(document, indices["bufferView"]), indices["byteOffset"].integer(0, limit, 0), count,
              size_of(component), size_of(component));
    const unsigned char* value =
        place(values, view_bytes(document, values["bufferView"]), values["byteOffset"].integer(0, limit, 0), count,
              a.element_bytes(), a.element_bytes());
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t element = load_integer(index + i * size_of(component), component);
        if (element >= a.count)
            indices.fail(fmt::format("index {} is out of range; the accessor has {} elements", element, a.count));
        put(element, value + i * a.element_bytes());
    }
}

}  // namespace

std::size_t accessor_count(const GltfDocument& document, const JsonValue& index) {
    return std::size_t(find_accessor(document, index)["count"].integer(1, max_gltf_elements));
}

std::vector<float> read_floats(const GltfDocument& document, const JsonValue& index, const FloatsWanted& wanted) {
    const Accessor a = open_accessor(document, index);
    if (a.components != wanted.components)
        a.json["type"].fail(wanted.components == 16 ? "expected MAT4 at " + index.pointer()
                                                    : fmt::format("expected VEC{} at {}", wanted.components, index.pointer()));
    const bool normalised = a.json["normalized"].flag(false);
    if (a.component != f32) {
        bool allowed = false;
        for (int integer : wanted.integers) allowed = allowed || integer == a.component;
        if (!allowed)
            a.json["componentType"].fail(wanted.integers.empty()
                                             ? fmt::format("expected 5126 (float) at {}", index.pointer())
                                             : fmt::format("expected {} or 5126 at {}", fmt::join(wanted.integers, ", "), index.pointer()));
        if (!normalised && !wanted.plain) a.json.fail("integers that are not normalized");
    }

    const std::size_t n = std::size_t(a.components), bytes = size_of(a.component);
    std::vector<float> values(a.count * n);
    const auto put = [&](std::size_t element, const unsigned char* from) {
        for (std::size_t c = 0; c < n; ++c) values[element * n + c] = load_float(from + c * bytes, a.component, normalised);
    };
    if (a.data)
        for (std::size_t i = 0; i < a.count; ++i) put(i, a.data + i * a.stride);
    replace_sparse(document, a, put);
    for (std::size_t i = 0; i < values.size(); ++i)
        if (!std::isfinite(values[i])) a.json.fail(fmt::format("element {} is not finite", i / n));
    return values;
}

std::vector<std::uint32_t> read_integers(const GltfDocument& document, const JsonValue& index, std::size_t limit,
                                         const char* things, int components) {
    const Accessor a = open_accessor(document, index);
    if (a.components != components)
        a.json["type"].fail(fmt::format("expected {} at {}", components == 1 ? "SCALAR" : fmt::format("VEC{}", components), index.pointer()));
    if (a.component != u8 && a.component != u16 && a.component != u32)
        a.json["componentType"].fail("expected one of 5121, 5123, 5125 at " + index.pointer());
    const std::size_t n = std::size_t(components), bytes = size_of(a.component);
    std::vector<std::uint32_t> values(a.count * n);
    const auto put = [&](std::size_t element, const unsigned char* from) {
        for (std::size_t c = 0; c < n; ++c) values[element * n + c] = load_integer(from + c * bytes, a.component);
    };
    if (a.data)
        for (std::size_t i = 0; i < a.count; ++i) put(i, a.data + i * a.stride);
    replace_sparse(document, a, put);
    for (std::size_t i = 0; i < values.size(); ++i)
        if (values[i] >= limit)
            index.fail(fmt::format("element {} is {}: out of range; there are {} {}", i / n, values[i], limit, things));
    return values;
}

}  // namespace plumb::io
