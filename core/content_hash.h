// A 64-bit hash of bytes, for golden values, caches and "same as before". Not against an adversary.
//
// The function is XXH64 (Collet, the xxHash specification), which reads gigabytes a second and has published values. It
// takes bytes as they are: who compares pictures makes every NaN the same one first.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>

#include "core/image.h"

namespace plumb {
namespace xxh64 {

inline constexpr std::uint64_t prime_1 = 0x9e3779b185ebca87, prime_2 = 0xc2b2ae3d27d4eb4f, prime_3 = 0x165667b19e3779f9,
                               prime_4 = 0x85ebca77c2b2ae63, prime_5 = 0x27d4eb2f165667c5;

template <class Word>
Word load(const unsigned char* p) {
    Word w;
    std::memcpy(&w, p, sizeof w);
    return w;
}
inline std::uint64_t round(std::uint64_t lane, std::uint64_t input) {
    return std::rotl(lane + input * prime_2, 31) * prime_1;
}
inline std::uint64_t merge(std::uint64_t hash, std::uint64_t lane) {
    return (hash ^ round(0, lane)) * prime_1 + prime_4;
}

}  // namespace xxh64

inline std::uint64_t content_hash(const void* data, std::size_t size, std::uint64_t seed = 0) {
    using namespace xxh64;
    const unsigned char* p = static_cast<const unsigned char*>(data);
    const unsigned char* const end = p + size;

    // Stripes of 32 bytes run through four lanes.
    std::uint64_t hash = seed + prime_5;
    if (size >= 32) {
        std::uint64_t lane[4] = {seed + prime_1 + prime_2, seed + prime_2, seed, seed - prime_1};
        for (; end - p >= 32; p += 32)
            for (int i = 0; i < 4; ++i) lane[i] = xxh64::round(lane[i], load<std::uint64_t>(p + 8 * i));
        hash = std::rotl(lane[0], 1) + std::rotl(lane[1], 7) + std::rotl(lane[2], 12) + std::rotl(lane[3], 18);
        for (std::uint64_t l : lane) hash = merge(hash, l);
    }
    hash += size;

    // The rest goes in by words of 8, 4 and 1 bytes.
    for (; end - p >= 8; p += 8)
        hash = std::rotl(hash ^ xxh64::round(0, load<std::uint64_t>(p)), 27) * prime_1 + prime_4;
    for (; end - p >= 4; p += 4) hash = std::rotl(hash ^ load<std::uint32_t>(p) * prime_1, 23) * prime_2 + prime_3;
    for (; p < end; ++p) hash = std::rotl(hash ^ *p * prime_5, 11) * prime_1;

    // Lets every bit reach every other.
    hash = (hash ^ hash >> 33) * prime_2;
    hash = (hash ^ hash >> 29) * prime_3;
    return hash ^ hash >> 32;
}

inline std::uint64_t content_hash(const std::string& text, std::uint64_t seed = 0) {
    return content_hash(text.data(), text.size(), seed);
}

// Of the size and the texels.
template <class T>
std::uint64_t content_hash(const Image<T>& image, std::uint64_t seed = 0) {
    const std::int32_t size[] = {image.width, image.height, std::int32_t(sizeof(T))};
    return content_hash(image.data(), image.size() * sizeof(T), content_hash(size, sizeof size, seed));
}

// As golden files write it: 16 hexadecimal digits.
inline std::string hash_text(std::uint64_t hash) {
    std::string text(16, '0');
    for (int i = 15; i >= 0; --i, hash >>= 4) text[std::size_t(i)] = "0123456789abcdef"[hash & 15];
    return text;
}

}  // namespace plumb
