// Guesses at what a shader does otherwise than its stage, made of the stage's description alone: another input, another
// uniform, another result. diagnosis.h runs the kernel under each and counts the pixels that agree.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/binding.h"

namespace plumb::parity {

struct Hypothesis {
    std::string text;  // "normal negated": the shader does that
    // Changes what the kernel is given; false where it would change nothing. Empty: it is given what was dumped.
    std::function<bool(StageData&)> change = {};
    // The pixel of the kernel's result that would lie at a pixel of the dump. Empty: the same.
    std::function<glm::ivec2(glm::ivec2)> place = {};
    // Changes what the kernel makes of a pixel of the dump: all components of all outputs. Empty: nothing.
    std::function<void(glm::ivec2, std::vector<BoundedValue>&)> result = {};
    // Makes all that the shader would write, in the kernel's place; false where that cannot be told.
    std::function<bool(Bundle&)> outputs = {};
    // Of the largest component: how far its arithmetic may lie from the shader's beyond what the kernel's bound says.
    double slack = 0;
    // It compares less than the verdict does: it says where to look, not what is wrong, and comes after its equals.
    bool aside = false;
};

// What computes in another order than a shader may be off by that, beyond the bound of the kernel.
inline constexpr double computed_slack = 0x1p-17;
// A ratio that has no name is known to that.
inline constexpr double ratio_slack = 0x1p-11;

// A number that goes by a name: "pi", "1 / 1000", "samples".
struct NamedNumber {
    std::string name;
    double value;
};
// What a result is taken times by mistake: constants, units, and the stage's own uniforms and their reciprocals.
std::vector<NamedNumber> named_numbers(const StageBinding& binding, const StageData& data);

// Of results: factors, channels swapped and left out, places, colour spaces, quantities of the inputs as factors.
// `ratios`: of got / expected, as seen on pixels that are wrong.
std::vector<Hypothesis> result_hypotheses(const StageBinding& binding, const StageData& data,
                                          const std::vector<double>& ratios);
// Of inputs: places, channels, axes, colour spaces, packing, one in place of another, buffers.
std::vector<Hypothesis> input_hypotheses(const StageBinding& binding, const StageData& data);
// Of uniforms: factors of scalars, counts off by one, rows of a matrix.
std::vector<Hypothesis> uniform_hypotheses(const StageBinding& binding, const StageData& data);

}  // namespace plumb::parity
