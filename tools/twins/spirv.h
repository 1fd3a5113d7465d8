// A reader of SPIR-V 1.3: instructions one after the other, and what the declarations at the front of a module say.
#pragma once

#include <cstdint>
#include <fstream>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace plumb::spirv {

enum Opcode : std::uint32_t {
    op_name = 5, op_member_name = 6, op_type_int = 21, op_type_float = 22, op_type_vector = 23, op_type_image = 25,
    op_type_sampled_image = 27, op_type_array = 28, op_type_runtime_array = 29, op_type_struct = 30, op_type_pointer = 32,
    op_constant = 43, op_variable = 59, op_load = 61, op_access_chain = 65, op_decorate = 71, op_member_decorate = 72,
};
enum Decoration : std::uint32_t { block = 2, non_writable = 24, location = 30, binding = 33, offset = 35 };
enum StorageClass : std::uint32_t { uniform_constant = 0, uniform = 2, output = 3, storage_buffer = 12 };

struct Instruction {
    std::uint32_t opcode;
    std::vector<std::uint32_t> words;  // without the first
};

struct Type {
    std::uint32_t opcode = 0;
    std::vector<std::uint32_t> words;  // after the result
};

struct Module {
    std::vector<Instruction> instructions;
    std::map<std::uint32_t, std::string> names;
    std::map<std::uint32_t, std::map<std::uint32_t, std::string>> member_names;
    std::map<std::uint32_t, std::map<std::uint32_t, std::uint32_t>> decorations;  // [id][decoration]: its first operand
    std::map<std::uint32_t, std::map<std::uint32_t, std::map<std::uint32_t, std::uint32_t>>> member_decorations;
    std::map<std::uint32_t, Type> types;
    std::map<std::uint32_t, std::uint32_t> constants;  // of 32 bits
};

inline std::string text_of(const std::vector<std::uint32_t>& words, std::size_t first) {
    std::string text;
    for (std::size_t i = first; i < words.size(); ++i)
        for (int byte = 0; byte < 4; ++byte) {
            const char c = char(words[i] >> (8 * byte) & 0xff);
            if (c == 0) return text;
            text += c;
        }
    return text;
}

// Throws std::runtime_error for what is no SPIR-V.
inline Module read_module(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(file)), {});
    auto word = [&](std::size_t i) {
        std::uint32_t w = 0;
        for (int b = 3; b >= 0; --b) w = w << 8 | std::uint8_t(bytes[4 * i + std::size_t(b)]);
        return w;
    };
    const std::size_t count = bytes.size() / 4;
    if (count < 5 || word(0) != 0x07230203) throw std::runtime_error(path + ": no SPIR-V");
    Module m;
    for (std::size_t i = 5; i < count;) {
        const std::size_t length = word(i) >> 16;
        if (length == 0 || i + length > count) throw std::runtime_error(path + ": cut off");
        Instruction in{word(i) & 0xffff, {}};
        for (std::size_t k = 1; k < length; ++k) in.words.push_back(word(i + k));
        i += length;
        const std::vector<std::uint32_t>& w = in.words;
        if (in.opcode == op_name) m.names[w[0]] = text_of(w, 1);
        if (in.opcode == op_member_name) m.member_names[w[0]][w[1]] = text_of(w, 2);
        if (in.opcode == op_decorate) m.decorations[w[0]][w[1]] = w.size() > 2 ? w[2] : 0;
        if (in.opcode == op_member_decorate) m.member_decorations[w[0]][w[1]][w[2]] = w.size() > 3 ? w[3] : 0;
        if (in.opcode >= 19 && in.opcode <= op_type_pointer) m.types[w[0]] = {in.opcode, {w.begin() + 1, w.end()}};
        if (in.opcode == op_constant && w.size() == 3) m.constants[w[1]] = w[2];
        m.instructions.push_back(std::move(in));
    }
    return m;
}

}  // namespace plumb::spirv
