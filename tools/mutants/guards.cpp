#include "tools/mutants/edit.h"
#include "tools/mutants/editor.h"

namespace plumb::mutants {
namespace {

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

SpirvModule guarded(const SpirvModule& module, std::uint32_t most_turns) {
    const SpirvIndex index(module);
    Editor e(module, index);
    bound_loops(e, module, most_turns);
    check_reads(e, module);
    hide_uniform_branches(e, module);
    return e.apply();
}

}  // namespace plumb::mutants
