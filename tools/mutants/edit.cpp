#include "tools/mutants/edit.h"

#include "tools/mutants/editor.h"

namespace plumb::mutants {
namespace {

std::uint32_t swapped_operator(std::uint32_t op) {
    switch (op) {
        case op_f_add: return op_f_sub;
        case op_f_sub: return op_f_add;
        case op_i_add: return op_i_sub;
        case op_i_sub: return op_i_add;
        case op_f_mul: return op_f_div;
        case op_f_div: return op_f_mul;
        case op_i_mul: return op_s_div;
        default: return op_i_mul;
    }
}

std::uint32_t swapped_function(std::uint32_t function) {
    return function < glsl_f_max ? function + 3 : function - 3;  // min of floats, unsigned, signed; then max
}

// a - b without a is -b.
void drop_term(Editor& e, std::size_t at, std::uint32_t part) {
    const Instruction i = e[at];
    const bool difference = i.opcode == op_f_sub || i.opcode == op_i_sub;
    if (part == 1 || !difference) return e.copy(at, i.words[part == 0 ? 3 : 2]);
    e.forget_decorations(i.words[1]);
    e[at] = {i.opcode == op_f_sub ? op_f_negate : op_s_negate, {i.words[0], i.words[1], i.words[3]}};
}

// Of a choice by && or || that skips its second condition: without the first, the branch to the second is always taken.
void drop_condition(Editor& e, const SpirvModule& module, std::size_t at, std::uint32_t part) {
    Instruction& i = e[at];
    if (i.opcode != op_phi) return e.copy(at, i.words[part == 0 ? 3 : 2]);
    if (part == 1) {
        i.words[4] = i.words[2];
        return;
    }
    std::size_t n = 0;
    while (!(module.code[n].opcode == op_label && module.code[n].words[0] == i.words[3])) ++n;
    while (module.code[n].opcode != op_branch_conditional) ++n;
    Instruction& branch = e[n];
    const bool goes_on = branch.words[1] != module.code[n - 1].words[0];  // true leads to the second condition
    branch.words[0] = e.global(goes_on ? 41 : 42, e.bool_type());         // OpConstantTrue, OpConstantFalse
}

// A constant times 1.01, or plus 1, for one use.
void change_constant(Editor& e, const Site& site) {
    Instruction& use = e[site.at];
    const std::uint32_t old = use.words[site.part], type = e.index().type_of(old), fresh = e.new_id();
    if (site.change == Change::constant_plus_one)
        e.before(site.at, {op_i_add, {type, fresh, old, e.filled(type, 1)}});
    else
        e.before(site.at, {op_f_mul, {type, fresh, old, e.filled(type, std::bit_cast<std::uint32_t>(1.01f))}});
    use.words[site.part] = fresh;
}

// The bound is the operand that is no load of what the loop counts; without knowing which, the second.
void shorten_loop(Editor& e, std::size_t at) {
    Instruction& i = e[at];
    const bool less = i.opcode == op_s_less || i.opcode == op_u_less || i.opcode == op_s_less_equal || i.opcode == op_u_less_equal;
    const std::uint32_t type = e.index().type_of(i.words[3]), fresh = e.new_id();
    e.before(at, {less ? op_i_sub : op_i_add, {type, fresh, i.words[3], e.filled(type, 1)}});
    i.words[3] = fresh;
}

void swap_components(Editor& e, std::size_t at) {
    Instruction& i = e[at];
    if (i.opcode == op_vector_shuffle) return std::swap(i.words[4], i.words[5]);
    if (i.opcode == op_composite_construct) return std::swap(i.words[2], i.words[3]);
    if (i.opcode == op_composite_extract) {
        i.words[3] = (i.words[3] + 1) % e.index().components(e.index().type_of(i.words[2]));
        return;
    }
    const std::uint32_t n = e.index().components(indexed_type(e.index(), i));
    const std::uint32_t component = e.index().definition(i.words.back())->words[2];
    i.words.back() = e.global(op_constant, e.int_type(), {(component + 1) % n});
}

void read_neighbour(Editor& e, const Site& site) {
    Instruction& i = e[site.at];
    std::uint32_t& place = site.part == 2 ? i.words.back() : i.words[3];
    const std::uint32_t type = e.index().type_of(place), fresh = e.new_id();
    const std::uint32_t n = e.index().components(type), scalar = e.index().component_type(type);
    std::uint32_t step = e.global(op_constant, scalar, {1});
    if (n > 1) {
        Ids parts(n, e.global(op_constant, scalar, {0}));
        parts[site.part == 1 ? 1 : 0] = step;
        step = e.global(op_constant_composite, type, parts);
    }
    e.before(site.at, {op_i_add, {type, fresh, place, step}});
    place = fresh;
}

void change_input(Editor& e, const Site& site) {
    const std::uint32_t type = e[site.at].words[0];
    if (site.change == Change::input_dropped) {
        const std::uint32_t old = e[site.at].words[1];
        e.renamed(site.at);
        return e.after(site.at, {op_copy_object, {type, old, e.global(op_constant_null, type)}});
    }
    const std::uint32_t old = e[site.at].words[1], fresh = e.renamed(site.at);
    e.after(site.at, {op_f_mul, {type, old, fresh, e.filled(type, std::bit_cast<std::uint32_t>(1.01f))}});
}

}  // namespace

void edit(Editor& e, const SpirvModule& module, const Site& site) {
    Instruction& i = e[site.at];
    switch (site.change) {
        case Change::plus_minus: i.opcode = swapped_operator(i.opcode); break;
        case Change::times_divide:
            if (i.opcode == op_i_mul && e.index().definition(e.index().component_type(i.words[0]))->words[2] == 0)
                i.opcode = op_u_div;
            else
                i.opcode = swapped_operator(i.opcode);
            break;
        case Change::min_max: i.words[3] = swapped_function(i.words[3]); break;
        case Change::comparison_turned:
            if (i.opcode == op_logical_not) return e.copy(site.at, i.words[2]);
            i.opcode = turned_comparison(i.opcode);
            break;
        case Change::boundary_moved: i.opcode = moved_boundary(i.opcode); break;
        case Change::condition_dropped: drop_condition(e, module, site.at, site.part); break;
        case Change::saturate_dropped: e.copy(site.at, site.part); break;
        case Change::limit_dropped: e.copy(site.at, i.words[site.part]); break;
        case Change::function_dropped:
        case Change::normalize_dropped:
        case Change::factor_dropped:
            if (i.opcode == op_ext_inst) return e.copy(site.at, i.words[4]);
            if (i.opcode == op_f_negate || i.opcode == op_s_negate) return e.copy(site.at, i.words[2]);
            e.copy(site.at, i.words[site.part == 0 ? 3 : 2]);
            break;
        case Change::term_dropped: drop_term(e, site.at, site.part); break;
        case Change::constant_scaled:
        case Change::constant_plus_one: change_constant(e, site); break;
        case Change::loop_bound:
            if (site.part == 0) return shorten_loop(e, site.at);
            i.opcode = moved_boundary(i.opcode);
            break;
        case Change::components_swapped: swap_components(e, site.at); break;
        case Change::neighbour_read: read_neighbour(e, site); break;
        case Change::input_dropped:
        case Change::input_scaled: change_input(e, site); break;
    }
}

SpirvModule changed(const SpirvModule& module, const SpirvIndex& index, const Site& site) {
    Editor e(module, index);
    edit(e, module, site);
    return e.apply();
}

}  // namespace plumb::mutants
