// Storage formats: what a GPU's render target makes of a value, to the bit.
//
// Each format has an encoder and a decoder that mirror its definition; quantise() is one after the other, what a later
// pass reads back. A layout names a format for each buffer, and a stage whose buffers are fp32 is the baseline against
// which the cost of a format is measured.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "core/number.h"

namespace plumb {

enum class Format : int {
    r32f,
    rgba32f,
    r16f,
    rgba16f,
    rgba8,         // unorm
    r11g11b10f,    // unsigned
    r10g10b10a2,   // unorm
    octahedral16,  // a unit vector in two 16-bit snorms
    octahedral8,   // the same in two 8-bit snorms
    d24s8,         // x: depth 0..1, y: stencil 0..255
    d32f,          // x: depth, clamped to 0..1
    rgbe,          // HEM 5.7: shared exponent in the alpha of rgba8
    normal8,       // ISR (22): a unit vector, each component in 8 bits
};

struct FormatInfo {
    Format format;
    const char* name;         // in scene files
    const char* vulkan_name;  // VkFormat without VK_FORMAT_
    int bytes;                // a texel
    int channels;             // components of a vec4 that are stored
};
const std::vector<FormatInfo>& formats();
const FormatInfo& info(Format format);
// Throws InputError at `place` for a name that formats() does not list.
Format parse_format(const std::string& name, const std::string& place);

// How a device rounds when it stores 16-bit floats. Vulkan allows both; lavapipe of Mesa 22.3 truncates.
enum class HalfStore : int { nearest, truncate };

// decode(encode(value)). Components that are not stored read as Vulkan says (0, 0, 0, 1), and as 0 after the vectors
// and rgbe, which a shader decodes.
void quantise(Format format, glm::vec4& value, HalfStore half_store = HalfStore::nearest);
void encode(Format format, const glm::vec4& value, void* texel, HalfStore half_store = HalfStore::nearest);
glm::vec4 decode(Format format, const void* texel);

// ---- The formats one by one ---------------------------------------------------------------------------------------

// IEEE binary16. nearest: ties to even, from 65520 on infinity. truncate: towards zero, finite values stay finite.
// Every NaN becomes 7e00. half_to_float (core/number.h) goes back, exactly.
Half float_to_half(float x, HalfStore half_store = HalfStore::nearest);

// Unsigned floats of 5 exponent bits and 6 or 5 mantissa bits, packed with red in the lowest bits. Negative values and
// -infinity become 0, finite ones the nearest finite value (at most 65024 and 64512), +infinity and NaN stay
// (OpenGL 4.6, 2.3.4.3 and 2.3.4.4).
std::uint32_t encode_r11g11b10f(const glm::vec3& rgb);
glm::vec3 decode_r11g11b10f(std::uint32_t packed);

// rint(scale * clamp(x, 0, 1)), ties to even, NaN to 0, with the product rounded to float as measured on lavapipe;
// scale is 2^bits - 1, bits <= 16.
std::uint32_t encode_unorm(float x, int bits);
float decode_unorm(std::uint32_t code, int bits);  // code / scale

// rint(scale * clamp(x, -1, 1)), NaN to 0; scale is 2^(bits-1) - 1. Decoding clamps: the lowest code is -1 too.
std::int32_t encode_snorm(float x, int bits);
float decode_snorm(std::int32_t code, int bits);

// Depth in the lower 24 bits, the product taken in double: a float has no room for it. Stencil in the upper 8.
std::uint32_t encode_d24s8(float depth, std::uint32_t stencil);
float decode_depth24(std::uint32_t packed);

// Octahedral map of unit vectors onto the square (Meyer et al. 2010, "On Floating-Point Normal Vectors"; folded as in
// Cigolle et al. 2014, "A Survey of Efficient Representations for Independent Unit Vectors"). The zero vector, which
// has no image, becomes +z.
glm::vec2 octahedral_from_unit(const glm::vec3& n);
glm::vec3 unit_from_octahedral(const glm::vec2& square);

// HEM 5.7: e = ceil(log2(max(r, g, b))) clamped to -128..127, stored as e + 128; mantissas rint(255 c / 2^e).
// differs: black has the lowest e (the printed log2(0) has none); the decoder divides mantissas by 255 (the printed one
// does not). Negative values and NaN become 0, more than 2^127 saturates.
glm::u8vec4 encode_rgbe(const glm::vec3& rgb);
glm::vec3 decode_rgbe(const glm::u8vec4& rgbe);

// ISR (22): 2 c / 255 - 1. No code decodes to 0: a zero component comes back as 1/255.
glm::u8vec3 encode_normal8(const glm::vec3& n);
glm::vec3 decode_normal8(const glm::u8vec3& packed);

}  // namespace plumb
