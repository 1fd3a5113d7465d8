#include "tools/mutants/edit.h"

#include <algorithm>
#include <bit>
#include <map>
#include <set>

namespace plumb::mutants {
namespace {

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

// A number of the invocation's own, 0 at first.
std::uint32_t private_number(Editor& e) {
    const std::uint32_t type = e.int_type();
    return e.global(op_variable, e.type(op_type_pointer, {storage_private, type}),
                    {storage_private, e.global(op_constant, type, {0})});
}

// NaN, or a number that nobody means.
std::uint32_t garbage(Editor& e, std::uint32_t type) {
    return e.filled(type, e.index().is_float(type) ? 0x7fc00000u : 0xfffffcc7u);
}

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

// A conditional back edge is taken only while turns are granted.
void grant(Editor& e, std::size_t at, std::uint32_t granted, bool taken_if_true) {
    const std::uint32_t truth = e.bool_type(), condition = e[at].words[0], both = e.new_id();
    if (taken_if_true) {
        e.before(at, {op_logical_and, {truth, both, condition, granted}});
    } else {
        const std::uint32_t denied = e.new_id();
        e.before(at, {op_logical_not, {truth, denied, granted}});
        e.before(at, {op_logical_or, {truth, both, condition, denied}});
    }
    e[at].words[0] = both;
}

// After the instruction `at`, whose value becomes garbage where `inside` is false.
void choose_garbage(Editor& e, std::size_t at, std::uint32_t inside) {
    const std::uint32_t type = e[at].words[0], old = e[at].words[1], n = e.index().components(type);
    const std::uint32_t fresh = e.renamed(at);
    if (n > 1) {
        const std::uint32_t all = e.new_id();
        Instruction splat{op_composite_construct, {e.type(op_type_vector, {e.bool_type(), n}), all}};
        splat.words.insert(splat.words.end(), n, inside);
        e.after(at, std::move(splat));
        inside = all;
    }
    e.after(at, {op_select, {type, old, inside, fresh, garbage(e, type)}});
}

// Reads beyond an image, of which Vulkan says nothing without robust access.
void check_fetch(Editor& e, const SpirvModule& module, std::size_t at) {
    const Instruction& i = module.code[at];
    const Instruction* image = e.index().type(i.words[2]);
    const std::uint32_t type = e.index().type_of(i.words[3]), n = e.index().components(type);
    constexpr std::uint32_t buffer_dimension = 5, lod_operand = 2;
    if (!image || image->words[2] == buffer_dimension || i.words.size() < 6 || i.words[4] != lod_operand) return;
    const std::uint32_t uint_type = e.type(op_type_int, {32, 0});
    const auto vector_of = [&](std::uint32_t scalar) { return n > 1 ? e.type(op_type_vector, {scalar, n}) : scalar; };
    const std::uint32_t uints = vector_of(uint_type), truths = vector_of(e.bool_type());
    const std::uint32_t size = e.new_id(), a = e.new_id(), b = e.new_id(), less = e.new_id();
    e.before(at, {op_image_query_size_lod, {type, size, i.words[2], i.words[5]}});
    e.before(at, {op_bitcast, {uints, a, i.words[3]}});
    e.before(at, {op_bitcast, {uints, b, size}});
    e.before(at, {op_u_less, {truths, less, a, b}});
    std::uint32_t inside = less;
    if (n > 1) e.before(at, {op_all, {e.bool_type(), inside = e.new_id(), less}});
    choose_garbage(e, at, inside);
}

// Reads beyond a buffer: block, member, index, and what more there is.
void check_load(Editor& e, const SpirvModule& module, std::size_t at) {
    const Instruction& load = module.code[at];
    const Instruction* chain = e.index().definition(load.words[2]);
    if (!chain || chain->opcode != op_access_chain || chain->words.size() < 5) return;
    if (e.index().storage(chain->words[2]) != storage_buffer || e.index().components(load.words[0]) == 0) return;
    const Instruction* variable = e.index().definition(chain->words[2]);
    if (!variable || variable->opcode != op_variable) return;
    Instruction whole{op_access_chain, {chain->words.begin(), chain->words.begin() + 5}};
    const Instruction* array = e.index().definition(indexed_type(e.index(), whole));
    if (!array || array->opcode != op_type_runtime_array) return;
    const std::uint32_t uint_type = e.type(op_type_int, {32, 0});
    const std::uint32_t length = e.new_id(), place = e.new_id(), inside = e.new_id();
    const std::uint32_t member = e.index().definition(chain->words[3])->words[2];
    e.before(at, {op_array_length, {uint_type, length, chain->words[2], member}});
    e.before(at, {op_bitcast, {uint_type, place, chain->words[4]}});
    e.before(at, {op_u_less, {e.bool_type(), inside, place, length}});
    choose_garbage(e, at, inside);
}

void check_reads(Editor& e, const SpirvModule& module) {
    constexpr std::uint32_t image_query = 50;
    bool fetches = false, queries = false;
    for (std::size_t n = e.index().first_function(); n < module.code.size(); ++n) {
        if (module.code[n].opcode == op_image_fetch) check_fetch(e, module, n), fetches = true;
        if (module.code[n].opcode == op_load) check_load(e, module, n);
    }
    for (const Instruction& i : module.code) queries |= i.opcode == op_capability && i.words[0] == image_query;
    if (fetches && !queries) e.before(0, {op_capability, {image_query}});
}

// Back edges count, and leave the loop after the last turn that is granted.
void bound_loops(Editor& e, const SpirvModule& module, std::uint32_t most_turns) {
    std::map<std::uint32_t, std::uint32_t> merges;  // of the loops met so far, by header
    std::uint32_t counter = 0, label = 0;
    for (std::size_t n = 0; n < module.code.size(); ++n) {
        const Instruction& i = module.code[n];
        if (i.opcode == op_label) label = i.words[0];
        const bool plain = i.opcode == op_branch && merges.count(i.words[0]);
        const bool chosen = i.opcode == op_branch_conditional && (merges.count(i.words[1]) || merges.count(i.words[2]));
        if (plain || chosen) {
            if (counter == 0) counter = private_number(e);
            const std::uint32_t type = e.int_type(), old = e.new_id(), more = e.new_id(), granted = e.new_id();
            e.before(n, {op_load, {type, old, counter}});
            e.before(n, {op_i_add, {type, more, old, e.global(op_constant, type, {1})}});
            e.before(n, {op_store, {counter, more}});
            e.before(n, {op_s_less, {e.bool_type(), granted, more, e.global(op_constant, type, {most_turns})}});
            if (plain)
                e[n] = {op_branch_conditional, {granted, i.words[0], merges[i.words[0]]}};
            else
                grant(e, n, granted, merges.count(i.words[1]) > 0);
        }
        if (i.opcode == op_loop_merge) merges[label] = i.words[0];
    }
}

// Lets no branch depend on uniforms alone: lavapipe compiles a shader again for each value of uniforms that decide one,
// which a mutant on many dispatches pays each time. The first input is never that number.
void hide_uniform_branches(Editor& e, const SpirvModule& module) {
    const Instruction* input = nullptr;
    std::uint32_t type = 0;
    for (const Instruction& i : module.code) {
        if (i.opcode != op_variable || i.words[2] != storage_input || input) continue;
        type = e.index().definition(i.words[0])->words[2];
        if (e.index().components(type) > 0) input = &i;
    }
    if (!input) return;
    const std::uint32_t scalar = e.index().component_type(type), impossible = 0x7fedcba9;
    for (std::size_t n = e.index().first_function(); n < module.code.size(); ++n) {
        if (module.code[n].opcode != op_branch_conditional) continue;
        std::size_t at = n;  // a merge stands right before its branch
        if (module.code[n - 1].opcode == op_selection_merge || module.code[n - 1].opcode == op_loop_merge) --at;
        const std::uint32_t loaded = e.new_id(), first = e.new_id(), bits = e.new_id(), real = e.new_id(), both = e.new_id();
        e.before(at, {op_load, {type, loaded, input->words[1]}});
        if (e.index().components(type) > 1)
            e.before(at, {op_composite_extract, {scalar, first, loaded, 0}});
        else
            e.before(at, {op_copy_object, {scalar, first, loaded}});
        e.before(at, {scalar == e.int_type() ? op_copy_object : op_bitcast, {e.int_type(), bits, first}});
        e.before(at, {op_i_not_equal, {e.bool_type(), real, bits, e.global(op_constant, e.int_type(), {impossible})}});
        e.before(at, {op_logical_and, {e.bool_type(), both, e[n].words[0], real}});
        e[n].words[0] = both;
    }
}

}  // namespace

SpirvModule changed(const SpirvModule& module, const SpirvIndex& index, const Site& site) {
    Editor e(module, index);
    edit(e, module, site);
    return e.apply();
}

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

SpirvModule guarded(const SpirvModule& module, std::uint32_t most_turns) {
    const SpirvIndex index(module);
    Editor e(module, index);
    bound_loops(e, module, most_turns);
    check_reads(e, module);
    hide_uniform_branches(e, module);
    return e.apply();
}

}  // namespace plumb::mutants
