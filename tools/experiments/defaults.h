// Whether every default lies on the front of error against time: `plumb experiment defaults`.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/isa.h"
#include "tools/shared/options.h"

namespace plumb::cli {

// What may stand in place of a default: settings beside the group's own.
struct Alternative {
    std::string name;               // as a table shows it: "samples = 100"
    std::vector<std::string> sets;  // of --set
};
// One decision, with what else could have been decided.
struct DefaultChoice {
    std::string name;  // "rsm.samples"
    std::vector<Alternative> others;
};
// Decisions that are judged by the same picture: of a method, by one of its layers against its path traced truth.
struct ChoiceGroup {
    std::string name, method;
    std::string layer;              // "indirect", "direct", "ao": irradiance or openness; "color": the picture
    std::vector<std::string> sets;  // what makes the method read what is chosen
    std::vector<DefaultChoice> choices;
};
const std::vector<ChoiceGroup>& default_choices();

// One setting of one scene at one size.
struct DefaultsRow {
    std::string scene, group, choice, setting;  // choice, setting: of the default itself empty and "default"
    glm::ivec2 size{0};
    double ms = 0;                  // median of the whole frame
    double error = 0, spread = 0;   // RMSE over the truth's mean, without the truth's noise; its standard error over seeds
    bool refused = false;           // cannot be rendered: `why`
    std::string why;
};

// The verdict on a default: against the least error of its alternatives that take no longer.
struct DefaultVerdict {
    std::string scene, group, choice;
    glm::ivec2 size{0};
    const DefaultsRow* own = nullptr;
    const DefaultsRow* best = nullptr;  // null: nothing is as fast
    enum class Is { on_front, near_front, not_told_apart, off } is = Is::on_front;
};

struct DefaultsRequest {
    std::vector<std::string> scenes, groups, sets;  // files; names of groups, empty: all; settings in place of defaults
    std::string preset;                             // frame::presets(), under those settings; empty: none
    std::vector<int> sizes = {256, 512, 1024};      // pixels a side
    int runs = 3;                                   // each with a seed of its own
    int samples = 64;                               // paths a pixel of the truth
    bool no_cache = false;
};

std::vector<DefaultsRow> measure_defaults(const DefaultsRequest& request, const RunOptions& options,
                                          const std::function<void(const std::string&)>& say);

// An alternative takes no longer if its median is at most `slack` times the default's. off: the default's error is more than
// `within` times the alternative's, and more than two standard errors of the difference above it.
inline constexpr double slack = 1.02, within = 1.1;
std::vector<DefaultVerdict> judge_defaults(const std::vector<DefaultsRow>& rows);

}  // namespace plumb::cli
