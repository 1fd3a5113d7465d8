#include "tools/mutants/spirv.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <sstream>

#include "core/error.h"

namespace plumb::mutants {
namespace {

constexpr std::uint32_t magic_number = 0x07230203;
constexpr std::size_t header_words = 5;

// Literal text, from an operand on.
std::string text_at(const Instruction& instruction, std::size_t first) {
    if (first >= instruction.words.size()) return "";
    std::string text((instruction.words.size() - first) * 4, '\0');
    std::memcpy(text.data(), instruction.words.data() + first, text.size());
    return text.substr(0, text.find('\0'));
}

std::vector<std::string> split_lines(const std::string& text) {
    std::vector<std::string> lines;
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) {
        const std::size_t first = line.find_first_not_of(" \t"), last = line.find_last_not_of(" \t\r");
        lines.push_back(first == std::string::npos ? "" : line.substr(first, last - first + 1));
    }
    return lines;
}

bool is_debug(std::uint32_t opcode) { return opcode >= op_source_continued && opcode <= op_line; }

}  // namespace

bool is_type(std::uint32_t opcode) { return opcode >= 19 && opcode <= 39; }

bool has_result(std::uint32_t op) {
    return op == op_ext_inst || (op >= 41 && op <= 55) || op == op_function_call || op == op_variable ||
           op == 60 || op == op_load || (op >= op_access_chain && op <= 70) || (op >= 77 && op <= 98) ||
           (op >= 100 && op <= 215) || op == 227 || (op >= 229 && op <= 242) || op == op_phi;
}

SpirvModule parse_spirv(std::span<const std::uint32_t> words) {
    if (words.size() < header_words || words[0] != magic_number) throw InputError("SPIR-V: no such header");
    SpirvModule module;
    std::copy_n(words.begin(), header_words, module.header.begin());
    for (std::size_t i = header_words; i < words.size();) {
        const std::size_t n = words[i] >> 16;
        if (n == 0 || n > words.size() - i) throw InputError("SPIR-V: an instruction is cut off");
        module.code.push_back({words[i] & 0xffff, {words.begin() + std::ptrdiff_t(i) + 1, words.begin() + std::ptrdiff_t(i + n)}});
        i += n;
    }
    return module;
}

std::vector<std::uint32_t> words_of(const SpirvModule& module) {
    std::vector<std::uint32_t> out(module.header.begin(), module.header.end());
    for (const Instruction& i : module.code) {
        if (is_debug(i.opcode)) continue;
        out.push_back(std::uint32_t(i.words.size() + 1) << 16 | i.opcode);
        out.insert(out.end(), i.words.begin(), i.words.end());
    }
    return out;
}

SpirvIndex::SpirvIndex(const SpirvModule& module) : module_(module) {
    std::string* source = nullptr;
    std::map<std::string, std::string> sources;
    for (std::size_t n = 0; n < module.code.size(); ++n) {
        const Instruction& i = module.code[n];
        if (is_type(i.opcode) || i.opcode == op_label) definitions_[i.words[0]] = n;
        if (has_result(i.opcode)) definitions_[i.words[1]] = n;
        if (i.opcode == op_name) names_[i.words[0]] = text_at(i, 1);
        if (i.opcode == op_string) strings_[i.words[0]] = text_at(i, 1);
        if (i.opcode == op_source && i.words.size() > 2) {
            source = &sources[strings_[i.words[2]]];
            *source = text_at(i, 3);
        }
        if (i.opcode == op_source_continued && source) *source += text_at(i, 0);
        if (i.opcode == op_store) stored_[i.words[0]].push_back(i.words[1]);
        if (i.opcode == op_function && first_function_ == 0) first_function_ = n;
    }
    for (const auto& [file, text] : sources) lines_[file] = split_lines(text);
    place_all();
}

void SpirvIndex::place_all() {
    Place place;
    for (const Instruction& i : module_.code) {
        if (i.opcode == op_function) {
            const std::string full = name(i.words[1]);
            place.function = full.substr(0, full.find('('));
        }
        if (i.opcode == op_line) {
            place.file = strings_[i.words[0]], place.line = int(i.words[1]);
            const std::vector<std::string>& lines = lines_[place.file];
            const std::size_t at = std::size_t(place.line) - 1;
            place.text = at < lines.size() ? lines[at] : "";
        }
        places_.push_back(place);
    }
}

const Instruction* SpirvIndex::definition(std::uint32_t id) const {
    const auto at = definitions_.find(id);
    return at == definitions_.end() ? nullptr : &module_.code[at->second];
}

std::uint32_t SpirvIndex::type_of(std::uint32_t id) const {
    const Instruction* i = definition(id);
    return i && has_result(i->opcode) ? i->words[0] : 0;
}

std::uint32_t SpirvIndex::component_type(std::uint32_t type) const {
    const Instruction* t = definition(type);
    return t && t->opcode == op_type_vector ? t->words[1] : type;
}

std::uint32_t SpirvIndex::components(std::uint32_t type) const {
    const Instruction* t = definition(type);
    if (!t) return 0;
    if (t->opcode == op_type_vector) return t->words[2];
    return t->opcode == op_type_float || t->opcode == op_type_int || t->opcode == op_type_bool ? 1 : 0;
}

bool SpirvIndex::is_float(std::uint32_t type) const {
    const Instruction* t = definition(component_type(type));
    return t && t->opcode == op_type_float;
}
bool SpirvIndex::is_integer(std::uint32_t type) const {
    const Instruction* t = definition(component_type(type));
    return t && t->opcode == op_type_int;
}

bool SpirvIndex::is_constant(std::uint32_t id) const {
    const Instruction* i = definition(id);
    return i && i->opcode >= 41 && i->opcode <= 52;
}

bool SpirvIndex::is_float_constant(std::uint32_t id, float value) const {
    const Instruction* i = definition(id);
    if (!i || !is_float(i->words[0])) return false;
    if (i->opcode == op_constant) return std::bit_cast<float>(i->words[2]) == value;
    if (i->opcode == op_constant_null) return value == 0;
    return i->opcode == op_constant_composite && std::all_of(i->words.begin() + 2, i->words.end(), [&](std::uint32_t part) {
        return is_float_constant(part, value);
    });
}

std::uint32_t SpirvIndex::storage(std::uint32_t pointer) const {
    const Instruction* t = type(pointer);
    return t && t->opcode == op_type_pointer ? t->words[1] : ~0u;
}

std::string SpirvIndex::name(std::uint32_t id) const {
    const auto at = names_.find(id);
    return at == names_.end() ? "" : at->second;
}

const Instruction* SpirvIndex::origin(std::uint32_t id) const {
    const Instruction* i = definition(id);
    while (i && i->opcode == op_load) {
        const auto values = stored_.find(i->words[2]);
        if (values == stored_.end() || values->second.size() != 1) break;
        i = definition(values->second[0]);
    }
    return i;
}

std::uint32_t SpirvIndex::find_type(std::uint32_t opcode, std::span<const std::uint32_t> operands) const {
    for (const Instruction& i : module_.code)
        if (i.opcode == opcode && std::equal(i.words.begin() + 1, i.words.end(), operands.begin(), operands.end()))
            return i.words[0];
    return 0;
}

}  // namespace plumb::mutants
