// Texels as Vulkan lays them out in memory, little-endian: the raw files that dumps are made of. Private to io/.
//
// core/formats.h says what a render target makes of a value; here are the codes that come back, of more formats, as
// doubles.
#pragma once

#include <string>
#include <vector>

namespace plumb::io {

enum class TexelKind {
    // One number a component.
    float32,
    float16,
    unorm8,
    snorm8,
    srgb8,
    unorm16,
    snorm16,
    // Integers.
    uint8,
    sint8,
    uint16,
    sint16,
    uint32,
    sint32,
    // Packed into 32 bits.
    ufloat_11_11_10,
    shared_exponent,
    unorm_10_2,
    depth24,
};

struct TexelFormat {
    const char* name;  // VkFormat without VK_FORMAT_
    TexelKind kind;
    int bytes, channels;
    bool swap_red_blue = false;
};

const std::vector<TexelFormat>& texel_formats();
// With VK_FORMAT_ or without; null for a name that is not there.
const TexelFormat* find_texel_format(const std::string& name);
bool is_integer(TexelKind kind);

// n texels to n records of four numbers; the components that the format lacks are 0, 0, 0, 1. Integers keep their
// value, unorm and snorm become code / max (not below -1), _SRGB is decoded to linear, as a shader reads it.
void decode_texels(const TexelFormat& format, const unsigned char* from, int n, double* to);

// How far component c of a decoded record may be from what was stored: one step between codes, to either neighbour.
// Shared exponents ask for the whole record.
double texel_step(TexelKind kind, const double* record, int c);

}  // namespace plumb::io
