// Generic mutants that need not be found, each with its reason.
//
//     [[survivor]]
//     file = "gi/isr/ssao.comp"            # of the source text; absent: any
//     function = "occlusion_of"
//     text = "precise float inverse = ..." # the line, wherever it stands; absent: every line of the function
//     change = "limit_dropped"             # absent: every change
//     sort = "equivalent"                  # equivalent | unreached | missed
//     reason = "..."
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/mutants/sites.h"

namespace plumb::mutants {

enum class Sort : int { equivalent, unreached, missed };
inline constexpr int sorts = 3;
const char* sort_name(Sort sort);

struct Survivor {
    std::string file, function, text;
    std::vector<Change> changes;  // empty: all
    Sort sort = Sort::equivalent;
    std::string reason;
    std::string place;  // "survivors.toml: line 12"

    bool matches(const Site& site) const;
};

// Throws InputError for what is no such list.
std::vector<Survivor> read_survivors(const std::string& file);

}  // namespace plumb::mutants
