// Raw dumps and pictures as tests make them, and what read_dump() made of them.
#pragma once

#include <cmath>
#include <initializer_list>
#include <limits>
#include <string>
#include <vector>

#include "files.h"
#include "io/manifest.h"

namespace plumb::io {

template <class T>
std::string bytes_of(std::initializer_list<T> values) {
    return std::string(reinterpret_cast<const char*>(values.begin()), values.size() * sizeof(T));
}
template <class T>
std::string bytes_of(const std::vector<T>& values) {
    return std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
}

inline DumpSpec raw(const std::string& file, const std::string& format, int width, int height) {
    DumpSpec spec;
    spec.file = file, spec.place = "m.toml: line 7: input.x of stage 1 (direct)";
    spec.vk_format = format, spec.width = width, spec.height = height;
    return spec;
}
inline DumpSpec picture(const std::string& file) {
    DumpSpec spec;
    spec.file = file, spec.place = "m.toml: line 7: input.x of stage 1 (direct)";
    return spec;
}

inline std::vector<float> floats(const DumpedImage& image) {
    REQUIRE(image.array.dtype == DType::f32);
    const auto values = elements<float>(image.array, image.array.shape);
    return {values.begin(), values.end()};
}
inline std::vector<std::int32_t> integers(const DumpedImage& image) {
    REQUIRE(image.array.dtype == DType::i32);
    const auto values = elements<std::int32_t>(image.array, image.array.shape);
    return {values.begin(), values.end()};
}

// Equal, NaN nowhere.
inline void require_values(const std::vector<float>& got, const std::vector<float>& expected) {
    REQUIRE(got.size() == expected.size());
    for (std::size_t i = 0; i < got.size(); ++i) {
        CAPTURE(i, got[i], expected[i]);
        REQUIRE(got[i] == expected[i]);
    }
}

}  // namespace plumb::io
