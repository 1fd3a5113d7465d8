#include "tools/mutants/edit.h"
#include "tools/mutants/editor.h"

namespace plumb::mutants {

std::uint32_t private_number(Editor& e) {
    const std::uint32_t type = e.int_type();
    return e.global(op_variable, e.type(op_type_pointer, {storage_private, type}),
                    {storage_private, e.global(op_constant, type, {0})});
}

std::uint32_t garbage(Editor& e, std::uint32_t type) {
    return e.filled(type, e.index().is_float(type) ? 0x7fc00000u : 0xfffffcc7u);
}

namespace {

// Instructions that read `flag`, and choose garbage instead of `value` where it is not 0.
std::vector<Instruction> spoil(Editor& e, std::uint32_t flag, std::uint32_t type, std::uint32_t value,
                               std::uint32_t& chosen) {
    const std::uint32_t n = e.index().components(type);
    if (n == 0 || (!e.index().is_float(type) && !e.index().is_integer(type))) return {};
    const std::uint32_t loaded = e.new_id(), set = e.new_id();
    chosen = e.new_id();
    std::vector<Instruction> out{{op_load, {e.int_type(), loaded, flag}},
                                 {op_i_not_equal, {e.bool_type(), set, loaded, e.global(op_constant, e.int_type(), {0})}}};
    std::uint32_t condition = set;
    if (n > 1) {
        condition = e.new_id();
        out.push_back({op_composite_construct, {e.type(op_type_vector, {e.bool_type(), n}), condition}});
        out.back().words.insert(out.back().words.end(), n, set);
    }
    out.push_back({op_select, {type, chosen, condition, garbage(e, type), value}});
    return out;
}

void spoil_outputs(Editor& e, const SpirvModule& module, std::uint32_t flag) {
    for (std::size_t n = e.index().first_function(); n < module.code.size(); ++n) {
        const Instruction& i = module.code[n];
        const bool stored = i.opcode == op_store && (e.index().storage(i.words[0]) == storage_output ||
                                                     e.index().storage(i.words[0]) == storage_buffer);
        if (!stored && i.opcode != op_image_write) continue;
        const std::size_t value = stored ? 1 : 2;
        std::uint32_t chosen = 0;
        for (Instruction& more : spoil(e, flag, e.index().type_of(i.words[value]), e[n].words[value], chosen)) e.before(n, std::move(more));
        if (chosen) e[n].words[value] = chosen;
    }
}

// Sets `flag` where the value `a` is not `b`, after the instruction `at`.
void compare(Editor& e, std::size_t at, std::uint32_t flag, std::uint32_t type, std::uint32_t a, std::uint32_t b) {
    const std::uint32_t n = e.index().components(type), truth = e.bool_type();
    const std::uint32_t truths = n > 1 ? e.type(op_type_vector, {truth, n}) : truth;
    std::uint32_t differs = e.new_id();
    const Instruction* scalar = e.index().definition(e.index().component_type(type));
    if (scalar->opcode == op_type_bool) {
        e.after(at, {165, {truths, differs, a, b}});  // OpLogicalNotEqual
    } else {
        std::uint32_t x = a, y = b;
        if (scalar->opcode == op_type_float) {
            const std::uint32_t bits = n > 1 ? e.type(op_type_vector, {e.int_type(), n}) : e.int_type();
            x = e.new_id(), y = e.new_id();
            e.after(at, {op_bitcast, {bits, x, a}}), e.after(at, {op_bitcast, {bits, y, b}});
        }
        e.after(at, {op_i_not_equal, {truths, differs, x, y}});
    }
    if (n > 1) {
        const std::uint32_t any = e.new_id();
        e.after(at, {op_any, {truth, any, differs}});
        differs = any;
    }
    const std::uint32_t old = e.new_id(), chosen = e.new_id();
    e.after(at, {op_load, {e.int_type(), old, flag}});
    e.after(at, {op_select, {e.int_type(), chosen, differs, e.global(op_constant, e.int_type(), {1}), old}});
    e.after(at, {op_store, {flag, chosen}});
}

// Whether the change's value can be held against the original's; if so both are computed and compared.
bool compare_original(Editor& e, const SpirvModule& module, const Site& site, std::uint32_t flag) {
    const Instruction original = module.code[site.at];
    if (!has_result(original.opcode) || original.opcode == op_phi) return false;
    const Instruction& next = module.code[site.at + 1];
    const bool chain = original.opcode == op_access_chain;
    if (chain && !(next.opcode == op_load && next.words[2] == original.words[1])) return false;
    const std::uint32_t type = chain ? next.words[0] : original.words[0];
    if (e.index().components(type) == 0) return false;

    Instruction copy = original;
    copy.words[1] = e.new_id();
    e.before(site.at, copy);
    std::uint32_t value = copy.words[1];
    if (chain) {
        value = e.new_id();
        e.before(site.at, {op_load, {type, value, copy.words[1]}});
    }
    const std::size_t last = chain ? site.at + 1 : site.at;
    compare(e, last, flag, type, value, module.code[last].words[1]);
    return true;
}

}  // namespace

SpirvModule marked(const SpirvModule& module, const SpirvIndex& index, const Site& site, Mark mark) {
    Editor e(module, index);
    const std::uint32_t flag = private_number(e);
    bool compared = false;
    if (mark == Mark::differed) {
        edit(e, module, site);
        compared = compare_original(e, module, site, flag);
    }
    if (!compared) {
        std::size_t at = site.at;
        while (module.code[at].opcode == op_phi || module.code[at].opcode == op_line) ++at;
        e.before(at, {op_store, {flag, e.global(op_constant, e.int_type(), {1})}});
    }
    spoil_outputs(e, module, flag);
    return e.apply();
}

}  // namespace plumb::mutants
