#include "tools/mutants/sites.h"

#include <algorithm>
#include <set>

#include "core/error.h"
#include "core/nearest_known.h"

namespace plumb::mutants {
namespace {

const std::vector<std::string> change_names{
    "plus_minus",        "times_divide",    "min_max",        "comparison_turned", "boundary_moved",
    "condition_dropped", "saturate_dropped", "limit_dropped",  "function_dropped",  "normalize_dropped",
    "term_dropped",      "factor_dropped",  "constant_scaled", "constant_plus_one", "loop_bound",
    "components_swapped", "neighbour_read",  "input_dropped",  "input_scaled"};

bool is_comparison(std::uint32_t op) { return turned_comparison(op) != 0; }

class Finder {
  public:
    Finder(const SpirvModule& module, const SpirvIndex& index) : module_(module), index_(index) { find_loops(); }

    std::vector<Site> find() {
        for (at_ = index_.first_function(); at_ < module_.code.size(); ++at_) {
            const Instruction& i = module_.code[at_];
            arithmetic(i), functions(i), conditions(i), constants(i), vectors(i), inputs(i);
        }
        return std::move(sites_);
    }

  private:
    void add(Change change, std::uint32_t part = 0) { sites_.push_back({change, at_, part, index_.places()[at_]}); }

    // Comparisons that decide whether a loop goes on.
    void find_loops() {
        std::set<std::uint32_t> merges;
        for (const Instruction& i : module_.code)
            if (i.opcode == op_loop_merge) merges.insert(i.words[0]);
        for (const Instruction& i : module_.code)
            if (i.opcode == op_branch_conditional && (merges.count(i.words[1]) || merges.count(i.words[2])))
                add_conditions(i.words[0]);
    }
    void add_conditions(std::uint32_t id) {
        const Instruction* i = index_.definition(id);
        if (!i) return;
        if (is_comparison(i->opcode)) loop_conditions_.insert(id);
        if (i->opcode == op_logical_and || i->opcode == op_logical_or) add_conditions(i->words[2]), add_conditions(i->words[3]);
        if (i->opcode == op_logical_not) add_conditions(i->words[2]);
        if (i->opcode == op_phi)
            for (std::size_t p = 2; p < i->words.size(); p += 2) add_conditions(i->words[p]);
    }

    // Whether both are read from one place: x x.
    bool same_value(std::uint32_t a, std::uint32_t b) const {
        if (a == b) return true;
        const Instruction *x = index_.definition(a), *y = index_.definition(b);
        if (!x || !y || x->opcode != y->opcode || x->words.size() != y->words.size()) return false;
        if (x->opcode == op_load) return same_value(x->words[2], y->words[2]);
        return x->opcode == op_access_chain && std::equal(x->words.begin() + 2, x->words.end(), y->words.begin() + 2);
    }

    bool is_root(std::uint32_t id) const {
        const Instruction* i = index_.origin(id);
        return i && i->opcode == op_ext_inst && i->words[3] == glsl_sqrt;
    }

    void arithmetic(const Instruction& i) {
        switch (i.opcode) {
            case op_f_add: case op_f_sub: case op_i_add: case op_i_sub:
                add(Change::plus_minus);
                add(Change::term_dropped, 0), add(Change::term_dropped, 1);
                break;
            case op_f_mul: case op_i_mul:
                add(Change::times_divide);
                add(Change::factor_dropped, 0);
                if (!same_value(i.words[2], i.words[3])) add(Change::factor_dropped, 1);
                break;
            case op_f_div: case op_u_div: case op_s_div:
                add(Change::times_divide);
                add(is_root(i.words[3]) ? Change::normalize_dropped : Change::factor_dropped, 1);
                break;
            case op_vector_times_scalar:
                add(Change::factor_dropped, 1);
                break;
            case op_f_negate: case op_s_negate:
                add(Change::function_dropped);
                break;
            default:
                break;
        }
    }

    void functions(const Instruction& i) {
        if (i.opcode != op_ext_inst) return;
        switch (i.words[3]) {
            case glsl_f_min: case glsl_u_min: case glsl_s_min: case glsl_f_max: case glsl_u_max: case glsl_s_max:
                add(Change::min_max);
                for (const std::uint32_t limit : {4, 5})
                    if (index_.is_constant(i.words[limit])) limit_of(i, 9 - limit);
                break;
            case glsl_f_clamp: case glsl_u_clamp: case glsl_s_clamp:
                add(Change::limit_dropped, 4);
                break;
            case glsl_normalize:
                add(Change::normalize_dropped, 4);
                break;
            case glsl_round_even: case glsl_f_abs: case glsl_s_abs: case glsl_floor: case glsl_ceil: case glsl_fract:
            case glsl_sqrt: case glsl_inverse_sqrt:
                add(Change::function_dropped, 4);
                break;
            default:
                break;
        }
    }
    // `kept` is the operand that is no constant.
    void limit_of(const Instruction& i, std::uint32_t kept) {
        add(Change::limit_dropped, kept);
        const Instruction* inner = index_.definition(i.words[kept]);
        if (!inner || inner->opcode != op_ext_inst || inner->words[3] == i.words[3]) return;
        if (inner->words[3] < glsl_f_min || inner->words[3] > glsl_s_max) return;
        for (const std::uint32_t limit : {4, 5})
            if (index_.is_constant(inner->words[limit])) add(Change::saturate_dropped, inner->words[9 - limit]);
    }

    void conditions(const Instruction& i) {
        if (is_comparison(i.opcode)) {
            add(Change::comparison_turned);
            const bool integers = index_.is_integer(index_.type_of(i.words[2]));
            const bool constant = index_.is_constant(i.words[2]) || index_.is_constant(i.words[3]);
            const bool looping = loop_conditions_.count(i.words[1]) > 0;
            if (moved_boundary(i.opcode) && looping && integers)
                add(Change::loop_bound, 0), add(Change::loop_bound, 1);
            else if (moved_boundary(i.opcode) && (integers || constant))
                add(Change::boundary_moved);
        }
        const bool both = i.opcode == op_logical_and || i.opcode == op_logical_or;
        const Instruction* type = has_result(i.opcode) ? index_.definition(i.words[0]) : nullptr;
        const bool chosen = i.opcode == op_phi && i.words.size() == 6 && type && type->opcode == op_type_bool;
        if (both || chosen) add(Change::condition_dropped, 0), add(Change::condition_dropped, 1);
        if (i.opcode == op_logical_not) add(Change::comparison_turned);
    }

    // Instructions that take constants as numbers.
    static bool computes(const Instruction& i) {
        return i.opcode == op_ext_inst || i.opcode == op_store || i.opcode == op_composite_construct ||
               (i.opcode >= 109 && i.opcode <= 205);
    }
    void constants(const Instruction& i) {
        if (!computes(i)) return;
        const std::size_t first = i.opcode == op_ext_inst ? 4 : i.opcode == op_store ? 1 : 2;
        for (std::size_t n = first; n < i.words.size(); ++n) {
            const std::uint32_t id = i.words[n], type = index_.type_of(id);
            if (!index_.is_constant(id)) continue;
            if (index_.is_float(type) && !index_.is_float_constant(id, 0)) add(Change::constant_scaled, std::uint32_t(n));
            if (index_.is_integer(type)) add(Change::constant_plus_one, std::uint32_t(n));
        }
    }

    void vectors(const Instruction& i) {
        const auto is_vector = [&](std::uint32_t type) { return index_.components(type) > 1; };
        if (i.opcode == op_composite_extract && i.words.size() == 4 && is_vector(index_.type_of(i.words[2])))
            add(Change::components_swapped);
        if (i.opcode == op_vector_shuffle && i.words.size() > 5 && i.words[4] != i.words[5]) add(Change::components_swapped);
        if (i.opcode == op_composite_construct && is_vector(i.words[0]) && i.words[2] != i.words[3] &&
            index_.type_of(i.words[2]) == index_.type_of(i.words[3]))
            add(Change::components_swapped);
        if (i.opcode == op_access_chain && is_vector(indexed_type(index_, i)) && index_.is_constant(i.words.back()))
            add(Change::components_swapped);
    }

    bool is_outside(std::uint32_t pointer) const {
        const std::uint32_t s = index_.storage(pointer);
        return s == storage_input || s == storage_uniform || s == storage_buffer || s == storage_push_constant;
    }
    // A block of uniforms that was copied into a function's parameter: structs of one name.
    bool is_copied_block(std::uint32_t pointer) const {
        const Instruction *chain = index_.definition(pointer), *type = nullptr;
        if (!chain || chain->opcode != op_access_chain || index_.storage(chain->words[2]) != storage_function) return false;
        if ((type = index_.type(chain->words[2]))) type = index_.definition(type->words[2]);
        if (!type || type->opcode != op_type_struct) return false;
        const std::string name = index_.name(type->words[0]);
        return std::any_of(module_.code.begin(), module_.code.end(), [&](const Instruction& v) {
            return v.opcode == op_variable && v.words[2] == storage_uniform && is_member(v.words[0], name);
        });
    }
    bool is_member(std::uint32_t pointer_type, const std::string& name) const {
        const Instruction* pointer = index_.definition(pointer_type);
        const Instruction* block = index_.definition(pointer->words[2]);
        return !name.empty() && block && block->opcode == op_type_struct &&
               std::any_of(block->words.begin() + 1, block->words.end(),
                           [&](std::uint32_t member) { return index_.name(member) == name; });
    }

    void inputs(const Instruction& i) {
        const bool fetched = i.opcode >= 87 && i.opcode <= 98;
        if (i.opcode == op_image_fetch) add(Change::neighbour_read, 0), add(Change::neighbour_read, 1);
        if (i.opcode == op_access_chain && !index_.is_constant(i.words.back())) {
            const Instruction* array = index_.definition(indexed_type(index_, i));
            if (is_outside(i.words[2]) && array && array->opcode == op_type_runtime_array) add(Change::neighbour_read, 2);
        }
        const bool loaded = i.opcode == op_load && (is_outside(i.words[2]) || is_copied_block(i.words[2]));
        if ((!fetched && !loaded) || index_.components(i.words[0]) == 0) return;
        add(Change::input_dropped);
        if (index_.is_float(i.words[0])) add(Change::input_scaled);
    }

    const SpirvModule& module_;
    const SpirvIndex& index_;
    std::set<std::uint32_t> loop_conditions_;
    std::vector<Site> sites_;
    std::size_t at_ = 0;
};

}  // namespace

const char* change_name(Change change) { return change_names[std::size_t(change)].c_str(); }

Change find_change(const std::string& name, const std::string& place) {
    const auto at = std::find(change_names.begin(), change_names.end(), name);
    if (at == change_names.end())
        throw InputError(place + ": unknown change \"" + name + "\"" + nearest_known(name, change_names, "\"\""));
    return Change(at - change_names.begin());
}

std::uint32_t turned_comparison(std::uint32_t op) {
    switch (op) {
        case op_i_equal: return op_i_not_equal;
        case op_i_not_equal: return op_i_equal;
        case op_u_greater: return op_u_less_equal;
        case op_s_greater: return op_s_less_equal;
        case op_u_greater_equal: return op_u_less;
        case op_s_greater_equal: return op_s_less;
        case op_u_less: return op_u_greater_equal;
        case op_s_less: return op_s_greater_equal;
        case op_u_less_equal: return op_u_greater;
        case op_s_less_equal: return op_s_greater;
        case op_f_equal: return op_f_not_equal;
        case op_f_not_equal: return op_f_equal;
        case op_f_less: return op_f_greater_equal;
        case op_f_greater: return op_f_less_equal;
        case op_f_less_equal: return op_f_greater;
        case op_f_greater_equal: return op_f_less;
        default: return 0;
    }
}

std::uint32_t moved_boundary(std::uint32_t op) {
    switch (op) {
        case op_u_greater: return op_u_greater_equal;
        case op_s_greater: return op_s_greater_equal;
        case op_u_greater_equal: return op_u_greater;
        case op_s_greater_equal: return op_s_greater;
        case op_u_less: return op_u_less_equal;
        case op_s_less: return op_s_less_equal;
        case op_u_less_equal: return op_u_less;
        case op_s_less_equal: return op_s_less;
        case op_f_less: return op_f_less_equal;
        case op_f_greater: return op_f_greater_equal;
        case op_f_less_equal: return op_f_less;
        case op_f_greater_equal: return op_f_greater;
        default: return 0;
    }
}

std::uint32_t indexed_type(const SpirvIndex& index, const Instruction& chain) {
    const Instruction* pointer = index.type(chain.words[2]);
    if (!pointer || pointer->opcode != op_type_pointer) return 0;
    std::uint32_t type = pointer->words[2];
    for (std::size_t n = 3; n + 1 < chain.words.size(); ++n) {
        const Instruction* t = index.definition(type);
        if (!t) return 0;
        if (t->opcode == op_type_struct) {
            const Instruction* member = index.definition(chain.words[n]);
            if (!member || member->opcode != op_constant) return 0;
            type = t->words[1 + member->words[2]];
        } else {
            type = t->words[1];
        }
    }
    return type;
}

std::vector<Site> find_sites(const SpirvModule& module, const SpirvIndex& index) {
    return Finder(module, index).find();
}

}  // namespace plumb::mutants
