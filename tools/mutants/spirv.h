// SPIR-V as a list of instructions that can be read and edited: types, constants, names, and the source line of each.
// Knows what glslang writes for our twins, not all of SPIR-V; checks nothing that a validator checks.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace plumb::mutants {

enum Op : std::uint32_t {
    op_source_continued = 2, op_source = 3, op_source_extension = 4, op_name = 5, op_member_name = 6, op_string = 7,
    op_line = 8, op_ext_inst_import = 11, op_ext_inst = 12, op_entry_point = 15, op_capability = 17, op_type_void = 19, op_type_bool = 20,
    op_type_int = 21, op_type_float = 22, op_type_vector = 23, op_type_array = 28, op_type_runtime_array = 29,
    op_type_struct = 30, op_type_pointer = 32, op_constant = 43, op_constant_composite = 44, op_constant_null = 46,
    op_function = 54, op_function_parameter = 55, op_function_end = 56, op_function_call = 57, op_variable = 59,
    op_load = 61, op_store = 62, op_access_chain = 65, op_array_length = 68, op_decorate = 71, op_vector_shuffle = 79,
    op_composite_construct = 80, op_composite_extract = 81, op_copy_object = 83, op_image_fetch = 95,
    op_image_write = 99, op_bitcast = 124, op_s_negate = 126, op_f_negate = 127, op_i_add = 128, op_f_add = 129, op_i_sub = 130,
    op_f_sub = 131, op_i_mul = 132, op_f_mul = 133, op_u_div = 134, op_s_div = 135, op_f_div = 136,
    op_vector_times_scalar = 142, op_image_query_size_lod = 103, op_any = 154, op_all = 155, op_logical_or = 166, op_logical_and = 167, op_logical_not = 168, op_select = 169,
    op_i_equal = 170, op_i_not_equal = 171, op_u_greater = 172, op_s_greater = 173, op_u_greater_equal = 174,
    op_s_greater_equal = 175, op_u_less = 176, op_s_less = 177, op_u_less_equal = 178, op_s_less_equal = 179,
    op_f_equal = 180, op_f_not_equal = 183, op_f_less = 184, op_f_greater = 186, op_f_less_equal = 188,
    op_f_greater_equal = 190, op_phi = 245, op_loop_merge = 246, op_selection_merge = 247, op_label = 248, op_branch = 249,
    op_branch_conditional = 250,
};

// Instructions of GLSL.std.450.
enum Glsl : std::uint32_t {
    glsl_round_even = 2, glsl_f_abs = 4, glsl_s_abs = 5, glsl_floor = 8, glsl_ceil = 9, glsl_fract = 10, glsl_sqrt = 31, glsl_inverse_sqrt = 32,
    glsl_f_min = 37, glsl_u_min = 38, glsl_s_min = 39, glsl_f_max = 40, glsl_u_max = 41, glsl_s_max = 42,
    glsl_f_clamp = 43, glsl_u_clamp = 44, glsl_s_clamp = 45, glsl_normalize = 69,
};

enum Storage : std::uint32_t {
    storage_input = 1, storage_uniform = 2, storage_output = 3, storage_private = 6, storage_function = 7,
    storage_push_constant = 9, storage_buffer = 12,
};

// Words are the operands alone; of what has a result they begin with its type and its id.
struct Instruction {
    std::uint32_t opcode = 0;
    std::vector<std::uint32_t> words;
};

bool has_result(std::uint32_t opcode);  // a type and an id
bool is_type(std::uint32_t opcode);     // an id alone

// Where an instruction comes from.
struct Place {
    std::string function;  // "occlusion_of"; overloads alike
    std::string file;      // as the compiler named it
    int line = 0;
    std::string text;      // that line, without what surrounds it
};

struct SpirvModule {
    std::array<std::uint32_t, 5> header{};
    std::vector<Instruction> code;

    std::uint32_t new_id() { return header[3]++; }
};

// Throws InputError for what is no SPIR-V.
SpirvModule parse_spirv(std::span<const std::uint32_t> words);
// Without names, lines and sources.
std::vector<std::uint32_t> words_of(const SpirvModule& module);

// What a module says about its ids.
class SpirvIndex {
  public:
    explicit SpirvIndex(const SpirvModule& module);

    // Of all three: null, or 0, where there is none.
    const Instruction* definition(std::uint32_t id) const;
    std::uint32_t type_of(std::uint32_t id) const;
    const Instruction* type(std::uint32_t id) const { return definition(type_of(id)); }

    bool is_float(std::uint32_t type) const;           // or a vector of them
    bool is_integer(std::uint32_t type) const;         // or a vector of them; no bool
    bool is_constant(std::uint32_t id) const;
    bool is_float_constant(std::uint32_t id, float value) const;  // a scalar, or all components
    std::uint32_t components(std::uint32_t type) const;  // 1 of a scalar, 0 of neither
    std::uint32_t component_type(std::uint32_t type) const;
    // Storage class of what a pointer points to.
    std::uint32_t storage(std::uint32_t pointer) const;
    std::string name(std::uint32_t id) const;
    // A value behind loads of variables that are stored once.
    const Instruction* origin(std::uint32_t id) const;
    // A type's id, or 0 where the module has none such.
    std::uint32_t find_type(std::uint32_t opcode, std::span<const std::uint32_t> operands) const;

    const std::vector<Place>& places() const { return places_; }  // one an instruction
    std::size_t first_function() const { return first_function_; }

  private:
    void place_all();

    const SpirvModule& module_;
    std::map<std::uint32_t, std::size_t> definitions_;
    std::map<std::uint32_t, std::string> names_, strings_;
    std::map<std::uint32_t, std::vector<std::uint32_t>> stored_;  // by variable
    std::map<std::string, std::vector<std::string>> lines_;       // by file
    std::vector<Place> places_;
    std::size_t first_function_ = 0;
};

}  // namespace plumb::mutants
