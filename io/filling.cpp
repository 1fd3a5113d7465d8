#include "io/filling.h"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <filesystem>

#include <fmt/format.h>

#include "io/random_file.h"

namespace plumb::io {
namespace {

constexpr std::uint32_t first_word = 0xffe00001, last_word = 0xfffffffe;

std::uint32_t word_at(const unsigned char* bytes) {
    std::uint32_t word;
    std::memcpy(&word, bytes, sizeof word);
    return word;
}

// Whether the whole file is that word; bytes behind the last whole word are not looked at.
bool is_all(const RandomFile& file, std::uint32_t word) {
    constexpr std::int64_t block = 1 << 16;
    std::vector<unsigned char> bytes;
    for (std::int64_t at = 0; at + 4 <= file.size(); at += block) {
        bytes.resize(std::size_t(std::min(block, file.size() - at) / 4 * 4));
        file.read(at, bytes.size(), bytes.data());
        for (std::size_t i = 0; i < bytes.size(); i += 4)
            if (word_at(&bytes[i]) != word) return false;
    }
    return true;
}

}  // namespace

std::uint32_t filling_word(std::uint64_t id) { return first_word + std::uint32_t(id % (last_word - first_word + 1)); }

bool is_filling(std::uint32_t word) { return word >= first_word && word <= last_word; }

std::uint32_t next_filling(std::uint32_t word) { return word == last_word ? first_word : word + 1; }

std::string filling_text(std::uint32_t word) { return fmt::format("{:08x}", word); }

std::optional<std::uint32_t> parse_filling(const std::string& text) {
    std::uint32_t word = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), word, 16);
    const bool whole = error == std::errc() && end == text.data() + text.size() && text.size() == 8;
    return whole && is_filling(word) ? std::optional(word) : std::nullopt;
}

std::vector<unsigned char> filled_bytes(std::uint32_t word, std::size_t bytes) {
    std::vector<unsigned char> out(bytes);
    for (std::size_t i = 0; i < bytes; ++i) out[i] = static_cast<unsigned char>(word >> (8 * (i % 4)));
    return out;
}

bool holds_word(const unsigned char* bytes, std::size_t size, std::uint32_t word) {
    for (std::size_t i = 0; i + 4 <= size; i += 4)
        if (word_at(bytes + i) == word) return true;
    return false;
}

FillingState look_for_filling(const std::string& path, std::uint32_t word) {
    std::error_code error;
    if (!std::filesystem::exists(path, error) && !error) return {true, "is missing"};
    const RandomFile file(path);
    if (file.size() == 0) return {true, "is empty"};
    if (file.size() < 4) return {};
    unsigned char start[4];
    file.read(0, sizeof start, start);
    if (!is_filling(word_at(start)) || !is_all(file, word_at(start))) return {};
    if (word_at(start) == word) return {true, "still holds what the export filled it with"};
    return {true, "holds what another export filled it with"};
}

}  // namespace plumb::io
