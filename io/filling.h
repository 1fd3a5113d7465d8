// What stands in an exported output until a renderer writes over it, so that a pass which writes nothing is told.
//
// A filling is one 32-bit word, repeated: as a float a NaN that no arithmetic makes, as an integer less than -1, where
// results hold indices and -1. Each export has a word of its own, drawn from what it exports.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace plumb::io {

// 0xffe00001 to 0xfffffffe: quiet NaNs with their sign and their second highest bit set. What processors and GPUs make
// of 0/0 is 0xffc00000, 0x7fc00000 or 0x7fffffff.
std::uint32_t filling_word(std::uint64_t id);
bool is_filling(std::uint32_t word);
// The next word of those, of the last the first.
std::uint32_t next_filling(std::uint32_t word);

// Eight hexadecimal digits; nothing for a word that is no filling.
std::string filling_text(std::uint32_t word);
std::optional<std::uint32_t> parse_filling(const std::string& text);

std::vector<unsigned char> filled_bytes(std::uint32_t word, std::size_t bytes);
// Whether a 32-bit word of the bytes, from the first on, is that one.
bool holds_word(const unsigned char* bytes, std::size_t size, std::uint32_t word);

// What is in a file that held a filling.
struct FillingState {
    bool nothing = false;    // nothing of it was written
    std::string why;         // "is missing", ...
};
// Reads no more than it takes to find one other word. Throws InputError where a file is there that cannot be read.
FillingState look_for_filling(const std::string& path, std::uint32_t word);

}  // namespace plumb::io
