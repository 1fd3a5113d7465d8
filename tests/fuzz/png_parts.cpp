#include "png_parts.h"

#include <zlib.h>

#include <algorithm>
#include <cstdint>

namespace plumb::fuzz {
namespace {

constexpr std::size_t signature_size = 8;

const Bytef* bytes_of(const std::string& s) { return reinterpret_cast<const Bytef*>(s.data()); }

std::string big_word(std::uint32_t value) {
    return {char(value >> 24), char(value >> 16 & 255), char(value >> 8 & 255), char(value & 255)};
}

}  // namespace

std::vector<PngChunk> split_png(const std::string& file) {
    std::vector<PngChunk> chunks;
    for (std::size_t at = signature_size; at + 12 <= file.size();) {
        std::uint32_t length = 0;
        for (std::size_t i = 0; i < 4; ++i) length = length << 8 | std::uint8_t(file[at + i]);
        if (length > file.size() - at - 12) break;
        chunks.push_back({file.substr(at + 4, 4), file.substr(at + 8, length)});
        at += 12 + length;
    }
    return chunks;
}

std::string join_png(const std::vector<PngChunk>& chunks) {
    std::string file = "\x89PNG\r\n\x1a\n";
    for (const PngChunk& chunk : chunks) {
        const std::string body = chunk.type + chunk.data;
        file += big_word(std::uint32_t(chunk.data.size())) + body +
                big_word(std::uint32_t(crc32(0, bytes_of(body), uInt(body.size()))));
    }
    return file;
}

std::optional<std::string> inflate(const std::string& stream, std::size_t limit) {
    std::string out(limit, '\0');
    z_stream z{};
    if (inflateInit(&z) != Z_OK) return {};
    z.next_in = const_cast<Bytef*>(bytes_of(stream)), z.avail_in = uInt(stream.size());
    z.next_out = reinterpret_cast<Bytef*>(out.data()), z.avail_out = uInt(out.size());
    const int result = ::inflate(&z, Z_SYNC_FLUSH);
    inflateEnd(&z);
    if (result < 0 && result != Z_BUF_ERROR) return {};
    out.resize(limit - z.avail_out);
    return out;
}

std::string deflate(const std::string& data) {
    uLongf size = compressBound(uLong(data.size()));
    std::string out(size, '\0');
    compress2(reinterpret_cast<Bytef*>(out.data()), &size, bytes_of(data), uLong(data.size()), 1);
    out.resize(size);
    return out;
}

}  // namespace plumb::fuzz
