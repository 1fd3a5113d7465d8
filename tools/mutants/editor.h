// Edits of a module, collected by the places of its instructions and applied all at once.
#pragma once

#include <algorithm>
#include <bit>
#include <map>
#include <set>
#include <vector>

#include "tools/mutants/sites.h"

namespace plumb::mutants {

using Ids = std::vector<std::uint32_t>;

// Collects edits of a module by the places of its instructions, and applies them all at once.
class Editor {
  public:
    Editor(const SpirvModule& module, const SpirvIndex& index) : module_(module), index_(index) {}

    std::uint32_t new_id() { return module_.new_id(); }
    const SpirvIndex& index() const { return index_; }
    Instruction& operator[](std::size_t at) { return module_.code[at]; }
    void before(std::size_t at, Instruction i) { before_[at].push_back(std::move(i)); }
    void after(std::size_t at, Instruction i) { after_[at].push_back(std::move(i)); }
    void forget_decorations(std::uint32_t id) { undecorated_.insert(id); }

    // Ids of what must stand before the first function; made where they are not there.
    std::uint32_t type(std::uint32_t opcode, const Ids& operands) {
        if (const std::uint32_t known = index_.find_type(opcode, operands)) return known;
        for (const Instruction& i : globals_)
            if (i.opcode == opcode && std::equal(i.words.begin() + 1, i.words.end(), operands.begin(), operands.end()))
                return i.words[0];
        Ids words{new_id()};
        words.insert(words.end(), operands.begin(), operands.end());
        globals_.push_back({opcode, words});
        return words[0];
    }
    std::uint32_t global(std::uint32_t opcode, std::uint32_t of_type, const Ids& operands = {}) {
        Ids words{of_type, new_id()};
        words.insert(words.end(), operands.begin(), operands.end());
        globals_.push_back({opcode, words});
        return words[1];
    }
    std::uint32_t float_type() { return type(op_type_float, {32}); }
    std::uint32_t int_type() { return type(op_type_int, {32, 1}); }
    std::uint32_t bool_type() { return type(op_type_bool, {}); }
    std::uint32_t number(float value) { return global(op_constant, float_type(), {std::bit_cast<std::uint32_t>(value)}); }
    // `value` in each component of a scalar or a vector.
    std::uint32_t filled(std::uint32_t of_type, std::uint32_t value) {
        const std::uint32_t scalar = global(op_constant, index_.component_type(of_type), {value});
        const std::uint32_t n = index_.components(of_type);
        return n > 1 ? global(op_constant_composite, of_type, Ids(n, scalar)) : scalar;
    }

    // Gives the instruction's result another id, which it returns: what follows `at` must define the old one.
    std::uint32_t renamed(std::size_t at) {
        const std::uint32_t old = module_.code[at].words[1], fresh = new_id();
        module_.code[at].words[1] = fresh;
        for (Instruction& i : module_.code)
            if (i.opcode == op_decorate && i.words[0] == old) i.words[0] = fresh;
        return fresh;
    }
    void copy(std::size_t at, std::uint32_t value) {
        Instruction& i = module_.code[at];
        forget_decorations(i.words[1]);
        i = {op_copy_object, {i.words[0], i.words[1], value}};
    }

    SpirvModule apply() {
        SpirvModule out;
        for (std::size_t n = 0; n < module_.code.size(); ++n) {
            if (n == index_.first_function()) append(out, globals_);
            append(out, before_[n]);
            const Instruction& i = module_.code[n];
            if (i.opcode != op_decorate || !undecorated_.count(i.words[0])) out.code.push_back(i);
            append(out, after_[n]);
        }
        out.header = module_.header;
        return out;
    }

  private:
    static void append(SpirvModule& out, const std::vector<Instruction>& more) {
        out.code.insert(out.code.end(), more.begin(), more.end());
    }

    SpirvModule module_;
    const SpirvIndex& index_;
    std::map<std::size_t, std::vector<Instruction>> before_, after_;
    std::vector<Instruction> globals_;
    std::set<std::uint32_t> undecorated_;
};

// The edit of a site.
void edit(Editor& e, const SpirvModule& module, const Site& site);
// A number of the invocation's own, 0 at first.
std::uint32_t private_number(Editor& e);
// NaN, or a number that nobody means.
std::uint32_t garbage(Editor& e, std::uint32_t type);

}  // namespace plumb::mutants
