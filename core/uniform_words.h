// What the members of a stage's uniform block mean, for who fills them by hand: each folder says it of its stages.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace plumb {

struct UniformWords {
    std::string member;  // as UniformMember has it; ".size" is that member of a struct, whatever the struct is called
    std::string unit, meaning;
    std::string harmless = {};            // what to write where a shader has no such thing, and why; "": nothing is
    std::optional<double> value = {};     // that, as a number for each component: taken where the member is not given,
    std::string alone = {};               // if this other member is 1; "": always
};

struct StageWords {
    std::string stage;  // "": all stages of the folder; what a stage says of itself comes first
    std::vector<UniformWords> members;
};

}  // namespace plumb
