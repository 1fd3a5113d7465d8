// PNG files byte by byte (ISO 15948), for tests: what is malformed in them is under right checksums.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace plumb::png_bytes {

// Four bytes, the highest first.
inline std::string word(std::uint32_t value) {
    std::string s;
    for (int shift = 24; shift >= 0; shift -= 8) s += char(value >> shift & 255);
    return s;
}

// Length, type, data, and the CRC of type and data (5.3 and annex D).
inline std::string chunk(const std::string& type, const std::string& data) {
    std::uint32_t crc = ~0u;
    for (const char c : type + data) {
        crc ^= std::uint8_t(c);
        for (int bit = 0; bit < 8; ++bit) crc = (crc & 1 ? 0xedb88320u : 0) ^ crc >> 1;
    }
    return word(std::uint32_t(data.size())) + type + data + word(~crc);
}

// At most 65535 bytes as a zlib stream of one stored block (RFC 1950 and RFC 1951, 3.2.4), with Adler-32.
inline std::string zlib(const std::string& data) {
    std::uint32_t a = 1, b = 0;
    for (const char c : data) {
        a = (a + std::uint8_t(c)) % 65521;
        b = (b + a) % 65521;
    }
    const std::uint32_t n = std::uint32_t(data.size());
    const std::string length = {char(n & 255), char(n >> 8)}, complement = {char(~n & 255), char(~n >> 8 & 255)};
    return "\x78\x01\x01" + length + complement + data + word(b << 16 | a);
}

// Colour: 0 grey, 2 RGB, 3 palette.
inline std::string header(std::uint32_t width, std::uint32_t height, int depth = 8, int color = 2, int interlace = 0) {
    return chunk("IHDR", word(width) + word(height) +
                             std::string{char(depth), char(color), 0, 0, char(interlace)});
}

inline std::string data(const std::string& rows) { return chunk("IDAT", zlib(rows)); }

inline std::string png(const std::string& chunks) { return "\x89PNG\r\n\x1a\n" + chunks + chunk("IEND", ""); }

struct BadPng {
    const char* kind;
    std::string bytes;
    std::string message;  // a part of it
};

// Pictures of 2 x 2: each row is a filter byte and two RGB pixels, or what stands in their place.
inline std::vector<BadPng> bad_pngs() {
    const std::string head = header(2, 2), good = data(std::string(14, '\0'));
    const std::string palette = header(2, 2, 8, 3), indices = data(std::string("\0\0\7\0\0\0", 6));
    return {
        {"PNG data are no zlib stream", png(head + chunk("IDAT", "rubbish and more of it")), "IDAT"},
        {"PNG checksum of the zlib stream",
         png(head + chunk("IDAT", zlib(std::string(14, '\0')).substr(0, 21) + "abcd")), "IDAT"},
        {"PNG with too little data", png(head + data(std::string(5, '\0'))), "Not enough"},
        {"PNG with an unknown filter", png(head + data("\x09" + std::string(13, '\0'))), "filter"},
        {"PNG without data", png(head), "IEND"},
        {"PNG without its palette", png(palette + indices), "PLTE"},
        {"PNG of 3 bits", png(header(2, 2, 3) + good), "IHDR"},
        {"PNG of width zero", png(header(0, 2) + good), "IHDR"},
        {"PNG with two headers", png(head + head + good), "IHDR"},
        {"PNG with an unknown critical chunk", png(head + chunk("ABCD", "x") + good), "ABCD"},
        {"PNG a pixel too wide", png(header(1000001, 1) + good), "IHDR"},
        {"PNG of 2^62 pixels", png(header(0x7fffffff, 0x7fffffff) + good), "IHDR"},
        {"PNG of more pixels than its bytes can hold", png(header(850'000, 5, 16, 6) + good), "too short for so many"},
        {"PNG interlaced with too little data", png(header(2, 2, 8, 2, 1) + data(std::string(5, '\0'))), "Not enough"},
    };
}

}  // namespace plumb::png_bytes
