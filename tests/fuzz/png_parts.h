// PNG files as chunks, and the zlib streams in them.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace plumb::fuzz {

struct PngChunk {
    std::string type, data;
};

// The chunks of a file as far as they are whole; checksums are not looked at.
std::vector<PngChunk> split_png(const std::string& file);
// A file of these chunks, with right lengths and checksums.
std::string join_png(const std::vector<PngChunk>& chunks);

// None where it is no zlib stream; at most `limit` bytes of it.
std::optional<std::string> inflate(const std::string& stream, std::size_t limit);
std::string deflate(const std::string& data);

}  // namespace plumb::fuzz
