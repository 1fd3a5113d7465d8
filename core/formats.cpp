#include "core/formats.h"

#include <bit>
#include <cmath>
#include <cstring>

#include "core/error.h"

namespace plumb {
namespace {

constexpr std::uint32_t float_infinity = 0x7f800000;

// value / 2^shift, rounded; shift >= 1.
std::uint32_t shift_rounded(std::uint32_t value, int shift, HalfStore mode) {
    if (shift > 31) return 0;
    const std::uint32_t quotient = value >> shift, rest = value & ((1u << shift) - 1), tie = 1u << (shift - 1);
    if (mode == HalfStore::truncate) return quotient;
    return quotient + (rest > tie || (rest == tie && (quotient & 1)));
}

// The bits of a finite float >= 0 as a float of 5 exponent bits; above the largest value, the code of infinity or
// beyond.
std::uint32_t small_float(std::uint32_t bits, int mantissa_bits, HalfStore mode) {
    const int exponent = int(bits >> 23), dropped = 23 - mantissa_bits;
    if (exponent > 112) return shift_rounded(bits - (112u << 23), dropped, mode);  // bias 127 to bias 15
    // A denormal: the significand itself, in units of 2^(-14 - mantissa_bits).
    return shift_rounded((bits & 0x7fffff) | 0x800000, dropped + 113 - exponent, mode);
}

std::uint32_t unsigned_small_float(float x, int mantissa_bits) {
    const std::uint32_t infinity = 31u << mantissa_bits, nan = infinity | 1u << (mantissa_bits - 1);
    const std::uint32_t bits = std::bit_cast<std::uint32_t>(x);
    if (x != x) return nan;
    if (!(x > 0)) return 0;
    if (bits == float_infinity) return infinity;
    return std::min(small_float(bits, mantissa_bits, HalfStore::nearest), infinity - 1);
}
float from_unsigned_small_float(std::uint32_t code, int mantissa_bits) {
    return half_to_float({std::uint16_t(code << (10 - mantissa_bits))});  // the same exponent, a shorter mantissa
}

float clamp01(float x) { return x > 0 ? (x < 1 ? x : 1.0f) : 0.0f; }  // NaN to 0
int round_to_int(float x) { return number<float>::round_to_index(x); }
int round_to_int(double x) { return number<double>::round_to_index(x); }

double power_of_two(int e) { return std::bit_cast<double>(std::uint64_t(e + 1023) << 52); }

// ceil(log2 x) for finite x > 0: the exponent, plus one unless x is a power of two.
int ceil_log2(float x) {
    const std::uint64_t bits = std::bit_cast<std::uint64_t>(double(x));  // a denormal float is a normal double
    return int(bits >> 52) - 1023 + ((bits & 0xfffffffffffff) != 0);
}

template <class T>
void put(void* texel, const T& value) {
    std::memcpy(texel, &value, sizeof value);
}
template <class T>
T get(const void* texel) {
    T value;
    std::memcpy(&value, texel, sizeof value);
    return value;
}

template <class Component>
void put_octahedral(void* texel, const glm::vec3& n) {
    const glm::vec2 p = octahedral_from_unit(n);
    const int bits = 8 * int(sizeof(Component));
    const Component code[2] = {Component(encode_snorm(p.x, bits)), Component(encode_snorm(p.y, bits))};
    std::memcpy(texel, code, sizeof code);
}
template <class Component>
glm::vec4 get_octahedral(const void* texel) {
    Component code[2];
    std::memcpy(code, texel, sizeof code);
    const int bits = 8 * int(sizeof(Component));
    return {unit_from_octahedral({decode_snorm(code[0], bits), decode_snorm(code[1], bits)}), 0};
}

}  // namespace

const std::vector<FormatInfo>& formats() {
    static const std::vector<FormatInfo> all = {
        {Format::r32f, "r32f", "R32_SFLOAT", 4, 1},
        {Format::rgba32f, "rgba32f", "R32G32B32A32_SFLOAT", 16, 4},
        {Format::r16f, "r16f", "R16_SFLOAT", 2, 1},
        {Format::rgba16f, "rgba16f", "R16G16B16A16_SFLOAT", 8, 4},
        {Format::rgba8, "rgba8", "R8G8B8A8_UNORM", 4, 4},
        {Format::r11g11b10f, "r11g11b10f", "B10G11R11_UFLOAT_PACK32", 4, 3},
        {Format::r10g10b10a2, "r10g10b10a2", "A2B10G10R10_UNORM_PACK32", 4, 4},
        {Format::octahedral16, "octahedral16", "R16G16_SNORM", 4, 3},
        {Format::octahedral8, "octahedral8", "R8G8_SNORM", 2, 3},
        {Format::d24s8, "d24s8", "D24_UNORM_S8_UINT", 4, 2},
        {Format::d32f, "d32f", "D32_SFLOAT", 4, 1},
        {Format::rgbe, "rgbe", "R8G8B8A8_UNORM", 4, 3},
        {Format::normal8, "normal8", "R8G8B8A8_UNORM", 4, 3},
    };
    return all;
}

const FormatInfo& info(Format format) { return formats()[std::size_t(format)]; }

Format parse_format(const std::string& name, const std::string& place) {
    std::string known;
    for (const FormatInfo& f : formats()) {
        if (name == f.name) return f.format;
        known += (known.empty() ? "" : ", ") + std::string(f.name);
    }
    throw InputError(place + ": format \"" + name + "\" is unknown; expected one of " + known);
}

void quantise(Format format, glm::vec4& value, HalfStore half_store) {
    unsigned char texel[16];
    encode(format, value, texel, half_store);
    value = decode(format, texel);
}

void encode(Format format, const glm::vec4& v, void* texel, HalfStore half_store) {
    const glm::vec3 xyz(v);
    switch (format) {
        case Format::r32f:
            return put(texel, v.x);
        case Format::rgba32f:
            return put(texel, v);
        case Format::r16f:
            return put(texel, float_to_half(v.x, half_store));
        case Format::rgba16f: {
            Half h[4];
            for (int c = 0; c < 4; ++c) h[c] = float_to_half(v[c], half_store);
            return put(texel, h);
        }
        case Format::rgba8: {
            glm::u8vec4 code;
            for (int c = 0; c < 4; ++c) code[c] = std::uint8_t(encode_unorm(v[c], 8));
            return put(texel, code);
        }
        case Format::r11g11b10f:
            return put(texel, encode_r11g11b10f(xyz));
        case Format::r10g10b10a2:
            return put(texel, encode_unorm(v.x, 10) | encode_unorm(v.y, 10) << 10 | encode_unorm(v.z, 10) << 20 |
                                  encode_unorm(v.w, 2) << 30);
        case Format::octahedral16:
            return put_octahedral<std::int16_t>(texel, xyz);
        case Format::octahedral8:
            return put_octahedral<std::int8_t>(texel, xyz);
        case Format::d24s8:
            return put(texel, encode_d24s8(v.x, encode_unorm(v.y / 255, 8)));
        case Format::d32f:
            return put(texel, clamp01(v.x));
        case Format::rgbe:
            return put(texel, encode_rgbe(xyz));
        case Format::normal8:
            return put(texel, glm::u8vec4(encode_normal8(xyz), 0));
    }
}

glm::vec4 decode(Format format, const void* texel) {
    switch (format) {
        case Format::r32f:
        case Format::d32f:
            return {get<float>(texel), 0, 0, 1};
        case Format::rgba32f:
            return get<glm::vec4>(texel);
        case Format::r16f:
            return {half_to_float(get<Half>(texel)), 0, 0, 1};
        case Format::rgba16f:
            return number<float>::fetch4(static_cast<const Half*>(texel), 0);
        case Format::rgba8: {
            const auto code = get<glm::u8vec4>(texel);
            return {decode_unorm(code.x, 8), decode_unorm(code.y, 8), decode_unorm(code.z, 8), decode_unorm(code.w, 8)};
        }
        case Format::r11g11b10f:
            return {decode_r11g11b10f(get<std::uint32_t>(texel)), 1};
        case Format::r10g10b10a2: {
            const auto p = get<std::uint32_t>(texel);
            return {decode_unorm(p & 1023, 10), decode_unorm(p >> 10 & 1023, 10), decode_unorm(p >> 20 & 1023, 10),
                    decode_unorm(p >> 30, 2)};
        }
        case Format::octahedral16:
            return get_octahedral<std::int16_t>(texel);
        case Format::octahedral8:
            return get_octahedral<std::int8_t>(texel);
        case Format::d24s8: {
            const auto p = get<std::uint32_t>(texel);
            return {decode_depth24(p), float(p >> 24), 0, 1};
        }
        case Format::rgbe:
            return {decode_rgbe(get<glm::u8vec4>(texel)), 0};
        case Format::normal8:
            return {decode_normal8(glm::u8vec3(get<glm::u8vec4>(texel))), 0};
    }
    return {};
}

Half float_to_half(float x, HalfStore half_store) {
    const std::uint32_t bits = std::bit_cast<std::uint32_t>(x), magnitude = bits & 0x7fffffff;
    const std::uint16_t sign = std::uint16_t(bits >> 16 & 0x8000);
    constexpr std::uint32_t infinity = 0x7c00, largest = 0x7bff;
    if (magnitude > float_infinity) return {0x7e00};
    if (magnitude == float_infinity) return {std::uint16_t(sign | infinity)};
    const std::uint32_t limit = half_store == HalfStore::nearest ? infinity : largest;
    return {std::uint16_t(sign | std::min(small_float(magnitude, 10, half_store), limit))};
}

std::uint32_t encode_r11g11b10f(const glm::vec3& c) {
    return unsigned_small_float(c.x, 6) | unsigned_small_float(c.y, 6) << 11 | unsigned_small_float(c.z, 5) << 22;
}
glm::vec3 decode_r11g11b10f(std::uint32_t p) {
    return {from_unsigned_small_float(p & 2047, 6), from_unsigned_small_float(p >> 11 & 2047, 6),
            from_unsigned_small_float(p >> 22, 5)};
}

std::uint32_t encode_unorm(float x, int bits) {
    return std::uint32_t(round_to_int(clamp01(x) * float((1 << bits) - 1)));
}
float decode_unorm(std::uint32_t code, int bits) { return float(code) / float((1 << bits) - 1); }

std::int32_t encode_snorm(float x, int bits) {
    const float magnitude = clamp01(std::fabs(x)) * float((1 << (bits - 1)) - 1);
    return x < 0 ? -round_to_int(magnitude) : round_to_int(magnitude);
}
float decode_snorm(std::int32_t code, int bits) {
    const float x = float(code) / float((1 << (bits - 1)) - 1);
    return x < -1 ? -1.0f : x;
}

std::uint32_t encode_d24s8(float depth, std::uint32_t stencil) {
    return std::uint32_t(round_to_int(double(clamp01(depth)) * 0xffffff)) | stencil << 24;
}
float decode_depth24(std::uint32_t packed) { return float(double(packed & 0xffffff) / 0xffffff); }

glm::vec2 octahedral_from_unit(const glm::vec3& n) {
    const float sum = std::fabs(n.x) + std::fabs(n.y) + std::fabs(n.z);
    if (!(sum > 0)) return {0, 0};
    const glm::vec2 p(n.x / sum, n.y / sum);
    if (n.z >= 0) return p;
    // The lower half: each corner of the square is folded over its edge of the diamond.
    const float x = 1 - std::fabs(p.y), y = 1 - std::fabs(p.x);
    return {p.x >= 0 ? x : -x, p.y >= 0 ? y : -y};
}
glm::vec3 unit_from_octahedral(const glm::vec2& p) {
    glm::vec3 n(p, 1 - std::fabs(p.x) - std::fabs(p.y));
    if (n.z < 0) {
        const float x = 1 - std::fabs(p.y), y = 1 - std::fabs(p.x);
        n.x = p.x >= 0 ? x : -x, n.y = p.y >= 0 ? y : -y;
    }
    return n / std::sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
}

glm::u8vec4 encode_rgbe(const glm::vec3& rgb) {
    // Takes negative values and NaN for 0, so that their comparison with the largest decides nothing.
    constexpr float largest_float = 0x1.fffffep127f;
    float c[3], largest = 0;
    for (int i = 0; i < 3; ++i) {
        c[i] = rgb[i] > 0 ? std::min(rgb[i], largest_float) : 0.0f;
        largest = std::max(largest, c[i]);
    }
    if (largest == 0) return {0, 0, 0, 0};
    const int e = std::min(std::max(ceil_log2(largest), -128), 127);
    glm::u8vec4 code;
    for (int i = 0; i < 3; ++i) code[i] = std::uint8_t(std::min(round_to_int(255 * (c[i] * power_of_two(-e))), 255));
    code.w = std::uint8_t(e + 128);
    return code;
}
glm::vec3 decode_rgbe(const glm::u8vec4& p) {
    const double range = power_of_two(int(p.w) - 128) / 255;
    return {float(p.x * range), float(p.y * range), float(p.z * range)};
}

glm::u8vec3 encode_normal8(const glm::vec3& n) {
    glm::u8vec3 code;
    for (int i = 0; i < 3; ++i) code[i] = std::uint8_t(encode_unorm(n[i] * 0.5f + 0.5f, 8));
    return code;
}
glm::vec3 decode_normal8(const glm::u8vec3& p) {
    return {2.0f * float(p.x) / 255 - 1, 2.0f * float(p.y) / 255 - 1, 2.0f * float(p.z) / 255 - 1};
}

}  // namespace plumb
