// Textures as a device holds them, and as a manifest describes their files.
#pragma once

#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "core/formats.h"
#include "core/image.h"
#include "io/manifest.h"

namespace plumb::foreign {

struct Texture {
    std::string format;  // VkFormat without VK_FORMAT_
    int width = 0, height = 0;
    std::vector<unsigned char> bytes;  // rows without padding
    bool bottom_first = false;         // the first row is the lowest
};

// Each texel as the format stores it.
Texture pack(const Image4& image, Format format);
// The same of unit vectors as codes of 0 to 1: (n + 1) / 2; w stays.
Texture pack_biased(const Image4& image, Format format);
Image4 unpack(const Texture& texture);  // of the formats that pack() makes
Texture upside_down(const Texture& texture);
Texture moved(const Texture& texture, int pixels);  // along x, what leaves comes in again

// Writes its file, and says what a manifest says of it.
io::DumpSpec write_texture(const std::string& folder, const std::string& name, const Texture& texture,
                           const std::string& channels = "", const std::string& encoding = "plain");

// Samples about the projection of a point: dx, dy in texels of the map, and the texels that one stands for.
using Pattern = std::vector<glm::vec3>;
// A spiral of equal areas (Vogel 1979) over a disc; `whole`: offsets are whole texels.
Pattern spiral(int samples, float radius, bool whole);
io::DumpSpec write_pattern(const std::string& folder, const std::string& name, const Pattern& pattern);

}  // namespace plumb::foreign
