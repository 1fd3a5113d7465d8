// Where a twin can be wrong: every place of its SPIR-V that a generic mutant changes, found from the instructions alone.
#pragma once

#include <string>
#include <vector>

#include "tools/mutants/spirv.h"

namespace plumb::mutants {

enum class Change : int {
    plus_minus,         // a + b for a - b, and back; of integers, too
    times_divide,       // a b for a / b, and back
    min_max,            // min for max, and back
    comparison_turned,  // a < b as a >= b, == as !=
    boundary_moved,     // a < b as a <= b; of integers, or against a constant: else a tie may legally go either way
    condition_dropped,  // a && b, a || b as a, and as b
    saturate_dropped,   // min(max(x, 0), 1) as x
    limit_dropped,      // max(0, x), min(x, limit) and clamp() as x
    function_dropped,   // abs, floor, root, negation: as the argument
    normalize_dropped,  // v / |v| as v: a division by a root, or normalize()
    term_dropped,       // a + b as a, and as b
    factor_dropped,     // a b as a, and as b; a / b as a
    constant_scaled,    // a float other than 0, times 1.01
    constant_plus_one,  // an integer
    loop_bound,         // one turn less, one turn more
    components_swapped, // x and y of a vector, or the next component
    neighbour_read,     // the next texel, the next element of a buffer
    input_dropped,      // what was read is 0
    input_scaled,       // what was read, times 1.01
};
inline constexpr int changes = 19;
const char* change_name(Change change);
// Throws InputError at `place` for an unknown one.
Change find_change(const std::string& name, const std::string& place);

struct Site {
    Change change = Change::plus_minus;
    std::size_t at = 0;      // of the instruction
    std::uint32_t part = 0;  // which operand, or which of two ways
    Place place;
};

// In the order of the instructions.
std::vector<Site> find_sites(const SpirvModule& module, const SpirvIndex& index);

// The type of what a chain of indices points to, before its last index.
std::uint32_t indexed_type(const SpirvIndex& index, const Instruction& chain);
// The other way round (`turned`), or with the tie decided otherwise; 0 for what is no comparison.
std::uint32_t turned_comparison(std::uint32_t opcode);
std::uint32_t moved_boundary(std::uint32_t opcode);

}  // namespace plumb::mutants
