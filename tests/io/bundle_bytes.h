// A file in the layout of bundles with whatever stands in its header, under right checksums. Written from io/README.md.
#pragma once

#include <string>

#include "core/content_hash.h"

namespace plumb::io {

inline std::string little_endian_bytes(std::uint64_t value, int count) {
    std::string bytes;
    for (int i = 0; i < count; ++i) bytes += char(value >> 8 * i & 255);
    return bytes;
}

// All that stands before arrays of that many bytes, zeros behind them counted.
inline std::string bundle_head(std::string header, std::uint64_t array_bytes, std::uint32_t version = 2) {
    const std::size_t start = (24 + header.size() + 8 + 63) / 64 * 64;
    header.resize(start - 32, ' ');
    const std::string head = "PLUMBNDL" + little_endian_bytes(version, 4) + little_endian_bytes(start, 4) +
                             little_endian_bytes(start + array_bytes, 8) + header;
    return head + little_endian_bytes(content_hash(head), 8);
}

inline std::string bundle_bytes(const std::string& header, const std::string& payload, std::uint32_t version = 2) {
    return bundle_head(header, payload.size(), version) + payload;
}

}  // namespace plumb::io
