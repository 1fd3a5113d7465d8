// Pictures as their files store them, through OpenImageIO. Private to io/.
#pragma once

#include <OpenImageIO/imageio.h>

#include <cstdint>
#include <string>
#include <vector>

#include "core/compare.h"

namespace plumb::io {

inline constexpr std::int64_t max_pixels = std::int64_t(1) << 31;
inline constexpr std::int64_t max_values = std::int64_t(1) << 34;
inline constexpr int max_channels = 1024;

// What decoding may cost is decided from the header. Of the compressions that are read, LZW packs most: under 4096 to 1.
inline std::size_t most_picture_bytes(std::size_t file_bytes) { return (std::size_t(1) << 20) + 4096 * file_bytes; }

// The header, and the pixels in the file's own number types.
struct Raw {
    OIIO::ImageSpec spec;
    std::vector<unsigned char> bytes;
    bool normalise = true;  // unsigned integers stand for 0..1
};

bool is_picture(const std::string& extension);  // one that is read

// Throws InputError for what is not one whole, flat picture within the limits and of at most `pixels`.
Raw read_raw(const std::string& path, std::int64_t pixels = max_pixels);
// The same of a file in memory: `extension` chooses the reader, `name` is for messages.
Raw decode_raw(const std::string& name, const std::string& extension, std::vector<unsigned char> file,
               std::int64_t pixels = max_pixels);

// Unsigned integers become 0..1, but for EXR, where they keep their value.
compare::Picture to_float(const std::string& path, const Raw& raw);

// OpenImageIO's messages in one line.
std::string reason(std::string message);

}  // namespace plumb::io
