// Guesses at what a shader does otherwise than its stage, made of the stage's description alone: another input, another
// uniform, another result. diagnosis.h runs the kernel under each and counts the pixels that agree.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/binding.h"

namespace plumb::parity {

// An image of the frame, changed texel by texel: what becomes of the texel at a pixel. `image`: as it was dumped.
struct TexelChange {
    std::string input;  // "": no such change
    std::size_t channels = 0;
    std::function<void(const float* image, glm::ivec2 at, float* texel)> change = {};
};

struct Hypothesis {
    std::string text;  // "normal negated": the shader does that
    // Changes what the kernel is given; false where it would change nothing. Empty: it is given what was dumped.
    std::function<bool(StageData&)> change = {};
    // The same change where it is one of an image of the frame: some pixels are then tried without changing all.
    TexelChange texels = {};
    // 1: what the kernel makes of the changed data is added to what it makes of what was dumped; -1: taken from it.
    int added = 0;
    // The pixel of the kernel's result that would lie at a pixel of the dump. Empty: the same.
    std::function<glm::ivec2(glm::ivec2)> place = {};
    // Changes what the kernel makes of a pixel of the dump: all components of all outputs. Empty: nothing.
    std::function<void(glm::ivec2, std::vector<BoundedValue>&)> result = {};
    // Makes what the shader would write, in the kernel's place, at these pixels at least (none: at all of them); false
    // where that cannot be told. It is slow, and tried only where no other guess explains what is wrong.
    std::function<bool(std::span<const glm::ivec2>, Bundle&)> outputs = {};
    // Of the largest component: how far its arithmetic may lie from the shader's beyond what the kernel's bound says.
    double slack = 0;
    // It compares less than the verdict does: it says where to look, not what is wrong, and comes after its equals.
    bool aside = false;
    // A number that was fitted to what was dumped, and no mistake by name: it comes after its equals, too.
    bool fitted = false;
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

// got / expected of one output that is the same at all wrong pixels: one number, or one for each of x, y and z.
struct SeenRatio {
    std::string output;
    std::vector<double> ratio;
};

// Of results: factors, channels swapped and left out, places, colour spaces, quantities of the inputs as factors.
// `ratios`: as seen on pixels that are wrong.
std::vector<Hypothesis> result_hypotheses(const StageBinding& binding, const StageData& data,
                                          const std::vector<double>& ratios);
// Of results: times a vector that the stage is given, and times powers of the distance to a point that it is given.
std::vector<Hypothesis> vector_hypotheses(const StageBinding& binding, const StageData& data,
                                          const std::vector<SeenRatio>& ratios);
// Of inputs: places, channels, axes, colour spaces, packing, one in place of another, buffers.
std::vector<Hypothesis> input_hypotheses(const StageBinding& binding, const StageData& data);
// Of uniforms: factors of scalars, limits left out, counts off by one, rows of a matrix.
std::vector<Hypothesis> uniform_hypotheses(const StageBinding& binding, const StageData& data);
// Of what is tried only where none of these explains what is wrong: images read some texels beside, other borders of
// maps, matrices by rows under usual planes.
std::vector<Hypothesis> far_hypotheses(const StageBinding& binding, const StageData& data);

// Guesses with a number in them that is looked for: "radius times r".
struct Family {
    std::string text;  // what is taken times the number
    std::function<Hypothesis(double)> at;
};
std::vector<Family> families(const StageBinding& binding, const StageData& data);

}  // namespace plumb::parity
