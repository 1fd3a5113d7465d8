#include "tools/mutants/selectable.h"

#include "core/error.h"

namespace plumb::mutants {

namespace {

constexpr std::uint32_t decoration_built_in = 11, decoration_no_contraction = 42, built_in_invocation = 28;

// The variable that holds the invocation's place.
std::uint32_t invocation_of(const SpirvModule& module) {
    for (const Instruction& i : module.code)
        if (i.opcode == op_decorate && i.words.size() == 3 && i.words[1] == decoration_built_in &&
            i.words[2] == built_in_invocation)
            return i.words[0];
    throw InputError("this is no compute stage");
}

// Stores z at the beginning of main, behind its variables.
void store_z(Editor& e, const SpirvModule& module, std::uint32_t to) {
    const std::uint32_t invocation = invocation_of(module);
    std::uint32_t main = 0;
    for (const Instruction& i : module.code)
        if (i.opcode == op_entry_point) main = i.words[1];
    std::size_t at = e.index().first_function();
    while (!(module.code[at].opcode == op_function && module.code[at].words[1] == main)) ++at;
    while (module.code[at].opcode != op_label) ++at;
    for (++at; module.code[at].opcode == op_variable || module.code[at].opcode == op_line;) ++at;
    const std::uint32_t uint_type = e.type(op_type_int, {32, 0}), uints = e.type(op_type_vector, {uint_type, 3});
    const std::uint32_t place = e.new_id(), z = e.new_id(), number = e.new_id();
    e.before(at, {op_load, {uints, place, invocation}});
    e.before(at, {op_composite_extract, {uint_type, z, place, 2}});
    e.before(at, {op_bitcast, {e.int_type(), number, z}});
    e.before(at, {op_store, {to, number}});
}

class Selector {
  public:
    Selector(Editor& e, const SpirvModule& module) : e_(e), module_(module), selected_(private_number(e)) {
        store_z(e, module, selected_);
        while (module.code[decorations_].opcode != op_decorate) ++decorations_;
    }

    void add(const PlacedChange& change, std::uint32_t number) {
        const Instruction original = module_.code[change.at];
        const std::uint32_t type = original.words[0], old = original.words[1], as_it_was = e_.new_id();
        change.edit(e_);
        const std::uint32_t changed = e_.renamed(change.at);
        if (e_[change.at].opcode == op_copy_object) e_.forget_decorations(changed);
        Instruction copy = original;
        copy.words[1] = as_it_was;
        e_.before(change.at, copy);
        if (no_contraction(old)) e_.before(decorations_, {op_decorate, {as_it_was, decoration_no_contraction}});

        const std::uint32_t n = e_.index().components(type), loaded = e_.new_id();
        std::uint32_t chosen = e_.new_id();
        e_.after(change.at, {op_load, {e_.int_type(), loaded, selected_}});
        e_.after(change.at, {op_i_equal, {e_.bool_type(), chosen, loaded, e_.global(op_constant, e_.int_type(), {number})}});
        if (n > 1) {
            const std::uint32_t all = e_.new_id();
            Instruction splat{op_composite_construct, {e_.type(op_type_vector, {e_.bool_type(), n}), all}};
            splat.words.insert(splat.words.end(), n, chosen);
            e_.after(change.at, std::move(splat));
            chosen = all;
        }
        e_.after(change.at, {op_select, {type, old, chosen, changed, as_it_was}});
    }

  private:
    bool no_contraction(std::uint32_t id) const {
        for (const Instruction& i : module_.code)
            if (i.opcode == op_decorate && i.words[0] == id && i.words[1] == decoration_no_contraction) return true;
        return false;
    }

    Editor& e_;
    const SpirvModule& module_;
    const std::uint32_t selected_;
    std::size_t decorations_ = 0;
};

}  // namespace

bool is_selectable(const SpirvModule& module, const SpirvIndex& index, std::size_t at) {
    const Instruction& i = module.code[at];
    return has_result(i.opcode) && i.opcode != op_phi && i.opcode != op_access_chain && i.opcode != op_variable &&
           index.components(i.words[0]) > 0;
}

SpirvModule selectable(const SpirvModule& module, const SpirvIndex& index, const std::vector<PlacedChange>& changes) {
    Editor e(module, index);
    Selector selector(e, module);
    for (std::size_t i = 0; i < changes.size(); ++i) selector.add(changes[i], std::uint32_t(i + 1));
    return e.apply();
}

}  // namespace plumb::mutants
