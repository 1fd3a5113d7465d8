#include "io/texel_format.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/flip.h"
#include "core/formats.h"
#include "core/number.h"

namespace plumb::io {
namespace {

using enum TexelKind;

template <class T>
T load(const unsigned char* p) {
    T value;
    std::memcpy(&value, p, sizeof value);
    return value;
}

double power_of_two(int e) { return std::bit_cast<double>(std::uint64_t(e + 1023) << 52); }

// Components of one type side by side.
template <class Code, class Decode>
void decode_components(const TexelFormat& format, const unsigned char* from, int n, double* to, Decode decode) {
    for (int i = 0; i < n; ++i, from += format.bytes, to += 4) {
        for (int c = 0; c < format.channels; ++c) to[c] = decode(load<Code>(from + c * int(sizeof(Code))));
        if (format.swap_red_blue) std::swap(to[0], to[2]);
    }
}

template <class Decode>
void decode_packed(const unsigned char* from, int n, double* to, Decode decode) {
    for (int i = 0; i < n; ++i) decode(load<std::uint32_t>(from + 4 * i), to + 4 * i);
}

template <class Code>
void decode_numbers(const TexelFormat& format, const unsigned char* from, int n, double* to) {
    decode_components<Code>(format, from, n, to, [](Code x) { return double(x); });
}
template <class Code>
void decode_unorms(const TexelFormat& format, const unsigned char* from, int n, double* to) {
    constexpr double max = std::numeric_limits<Code>::max();
    decode_components<Code>(format, from, n, to, [](Code x) { return x / max; });
}
template <class Code>
void decode_snorms(const TexelFormat& format, const unsigned char* from, int n, double* to) {
    constexpr double max = std::numeric_limits<Code>::max();
    decode_components<Code>(format, from, n, to, [](Code x) { return std::max(x / max, -1.0); });
}

void decode_srgb(const TexelFormat& format, const unsigned char* from, int n, double* to) {
    static const std::array<double, 256> linear = [] {
        std::array<double, 256> table{};
        for (std::size_t code = 0; code < 256; ++code) table[code] = compare::srgb_to_linear(double(code) / 255);
        return table;
    }();
    for (int i = 0; i < n; ++i, from += 4, to += 4) {
        for (int c = 0; c < 3; ++c) to[c] = linear[from[c]];
        to[3] = from[3] / 255.0;
        if (format.swap_red_blue) std::swap(to[0], to[2]);
    }
}

// Vulkan 1.3, 16.1.6: red, green, blue as m 2^(e - 15 - 9), the exponent in the upper five bits.
void decode_shared_exponent(const unsigned char* from, int n, double* to) {
    decode_packed(from, n, to, [](std::uint32_t p, double* v) {
        const double step = power_of_two(int(p >> 27) - 24);
        for (int c = 0; c < 3; ++c) v[c] = (p >> 9 * c & 511) * step;
    });
}

}  // namespace

const std::vector<TexelFormat>& texel_formats() {
    static const std::vector<TexelFormat> all = {
        {"R32G32B32A32_SFLOAT", float32, 16, 4},
        {"R32G32B32_SFLOAT", float32, 12, 3},
        {"R32G32_SFLOAT", float32, 8, 2},
        {"R32_SFLOAT", float32, 4, 1},
        {"R16G16B16A16_SFLOAT", float16, 8, 4},
        {"R16G16B16_SFLOAT", float16, 6, 3},
        {"R16G16_SFLOAT", float16, 4, 2},
        {"R16_SFLOAT", float16, 2, 1},
        {"R8G8B8A8_UNORM", unorm8, 4, 4},
        {"R8G8B8A8_SRGB", srgb8, 4, 4},
        {"B8G8R8A8_UNORM", unorm8, 4, 4, true},
        {"B8G8R8A8_SRGB", srgb8, 4, 4, true},
        {"R8G8B8_UNORM", unorm8, 3, 3},
        {"R8G8_UNORM", unorm8, 2, 2},
        {"R8_UNORM", unorm8, 1, 1},
        {"R8G8B8A8_SNORM", snorm8, 4, 4},
        {"R8G8_SNORM", snorm8, 2, 2},
        {"R8_SNORM", snorm8, 1, 1},
        {"R16G16B16A16_UNORM", unorm16, 8, 4},
        {"R16G16_UNORM", unorm16, 4, 2},
        {"R16_UNORM", unorm16, 2, 1},
        {"R16G16B16A16_SNORM", snorm16, 8, 4},
        {"R16G16_SNORM", snorm16, 4, 2},
        {"R16_SNORM", snorm16, 2, 1},
        {"A2B10G10R10_UNORM_PACK32", unorm_10_2, 4, 4},
        {"A2R10G10B10_UNORM_PACK32", unorm_10_2, 4, 4, true},
        {"B10G11R11_UFLOAT_PACK32", ufloat_11_11_10, 4, 3},
        {"E5B9G9R9_UFLOAT_PACK32", shared_exponent, 4, 3},
        {"D32_SFLOAT", float32, 4, 1},
        {"D32_SFLOAT_S8_UINT", float32, 4, 1},
        {"D24_UNORM_S8_UINT", depth24, 4, 1},
        {"X8_D24_UNORM_PACK32", depth24, 4, 1},
        {"D16_UNORM", unorm16, 2, 1},
        {"R32G32B32A32_SINT", sint32, 16, 4},
        {"R32G32B32A32_UINT", uint32, 16, 4},
        {"R32G32_SINT", sint32, 8, 2},
        {"R32G32_UINT", uint32, 8, 2},
        {"R32_SINT", sint32, 4, 1},
        {"R32_UINT", uint32, 4, 1},
        {"R16G16B16A16_SINT", sint16, 8, 4},
        {"R16G16B16A16_UINT", uint16, 8, 4},
        {"R16G16_SINT", sint16, 4, 2},
        {"R16G16_UINT", uint16, 4, 2},
        {"R16_SINT", sint16, 2, 1},
        {"R16_UINT", uint16, 2, 1},
        {"R8G8B8A8_SINT", sint8, 4, 4},
        {"R8G8B8A8_UINT", uint8, 4, 4},
        {"R8G8_UINT", uint8, 2, 2},
        {"R8_UINT", uint8, 1, 1},
    };
    return all;
}

const TexelFormat* find_texel_format(const std::string& name) {
    const std::string prefix = "VK_FORMAT_";
    const std::string bare = name.compare(0, prefix.size(), prefix) == 0 ? name.substr(prefix.size()) : name;
    for (const TexelFormat& format : texel_formats())
        if (bare == format.name) return &format;
    return nullptr;
}

bool is_integer(TexelKind kind) { return kind >= uint8 && kind <= sint32; }

void decode_texels(const TexelFormat& format, const unsigned char* from, int n, double* to) {
    for (int i = 0; i < n; ++i) to[4 * i] = to[4 * i + 1] = to[4 * i + 2] = 0, to[4 * i + 3] = 1;
    switch (format.kind) {
        case float32:
            return decode_numbers<float>(format, from, n, to);
        case float16:
            return decode_components<Half>(format, from, n, to, [](Half h) { return double(half_to_float(h)); });
        case unorm8:
            return decode_unorms<std::uint8_t>(format, from, n, to);
        case snorm8:
            return decode_snorms<std::int8_t>(format, from, n, to);
        case srgb8:
            return decode_srgb(format, from, n, to);
        case unorm16:
            return decode_unorms<std::uint16_t>(format, from, n, to);
        case snorm16:
            return decode_snorms<std::int16_t>(format, from, n, to);
        case uint8:
            return decode_numbers<std::uint8_t>(format, from, n, to);
        case sint8:
            return decode_numbers<std::int8_t>(format, from, n, to);
        case uint16:
            return decode_numbers<std::uint16_t>(format, from, n, to);
        case sint16:
            return decode_numbers<std::int16_t>(format, from, n, to);
        case uint32:
            return decode_numbers<std::uint32_t>(format, from, n, to);
        case sint32:
            return decode_numbers<std::int32_t>(format, from, n, to);
        case ufloat_11_11_10:
            return decode_packed(from, n, to, [](std::uint32_t p, double* v) {
                const glm::vec3 rgb = decode_r11g11b10f(p);
                for (int c = 0; c < 3; ++c) v[c] = rgb[c];
            });
        case shared_exponent:
            return decode_shared_exponent(from, n, to);
        case unorm_10_2:
            return decode_packed(from, n, to, [&](std::uint32_t p, double* v) {
                for (int c = 0; c < 3; ++c) v[c] = (p >> 10 * c & 1023) / 1023.0;
                v[3] = (p >> 30) / 3.0;
                if (format.swap_red_blue) std::swap(v[0], v[2]);
            });
        case depth24:
            return decode_packed(from, n, to, [](std::uint32_t p, double* v) { v[0] = (p & 0xffffff) / 16777215.0; });
    }
}

namespace {

// One unit in the last place of a float with that many fraction bits, whose least normal number is 2^least.
double float_step(double x, int bits, int least) {
    const double magnitude = std::fabs(x);
    if (!(magnitude < std::numeric_limits<double>::infinity())) return 0;
    const double normal = std::max(magnitude, power_of_two(least));
    const int exponent = int(std::bit_cast<std::uint64_t>(normal) >> 52) - 1023;
    return power_of_two(exponent - bits);
}

}  // namespace

double texel_step(TexelKind kind, const double* v, int c) {
    switch (kind) {
        case float32:
            return float_step(v[c], 23, -126);
        case float16:
            return float_step(v[c], 10, -14);
        case ufloat_11_11_10:
            return float_step(v[c], c == 2 ? 5 : 6, -14);
        case shared_exponent: {
            // Radiance's mantissas have 8 bits, those of E5B9G9R9 9; the largest one has its first bit set.
            const double largest = std::max({v[0], v[1], v[2]});
            return float_step(largest, 7, -16);
        }
        case unorm8:
            return 1 / 255.0;
        case snorm8:
            return 1 / 127.0;
        case unorm16:
            return 1 / 65535.0;
        case snorm16:
            return 1 / 32767.0;
        case unorm_10_2:
            return c == 3 ? 1 / 3.0 : 1 / 1023.0;
        case depth24:
            return 1 / 16777215.0;
        case srgb8:
            // The curve's slope is 2.4 / 1.055 v^(1.4/2.4), at most that of the square root, and 1 / 12.92 below.
            return c == 3 ? 1 / 255.0 : (2.3 * std::sqrt(v[c]) + 0.08) / 255;
        default:
            return 0;
    }
}

}  // namespace plumb::io
