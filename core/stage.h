// What a stage says about itself: the row in `plumb stages`.
#pragma once

#include <string>
#include <vector>

#include "core/fields.h"
#include "core/image.h"

namespace plumb {

// A named input or output. `type` is what a GPU would bind: "image rgba32f", "image r32f", "records rsm", "buffer i32".
struct Port {
    std::string name, type, unit, meaning;
};

// How far float may be from double: C * eps * condition (verification.md, `plumb stability`).
struct Budget {
    double c = 16;
    std::string reason;  // where c is above 16
};

// What a million turns of a stage's inner loop take on one core with AVX-512, by the benchmarks; it orders stages by
// cost and promises nothing.
struct Cost {
    double ms_per_million = 0;
    std::string unit = {};  // of what is counted: "pixels", "samples"
};

struct ParamInfo {
    std::string name, type, unit, meaning, default_value, range;
};

struct StageInfo {
    std::string name;    // as `plumb stages` lists it
    std::string source;  // the document and its section or equation
    std::vector<Port> inputs, outputs;
    std::vector<ParamInfo> params;
    std::string twin;    // path of the GLSL twin from the project's root; empty: none, and `source` says why
    Budget budget;
};

// The parameters' rows, from fields() of a default-constructed Params.
std::vector<ParamInfo> describe(const std::vector<Field>& fields);
// Of those named, in the fields' order. Throws std::logic_error for a name that is none of them.
std::vector<ParamInfo> describe(const std::vector<Field>& fields, const std::vector<std::string>& names);

}  // namespace plumb
