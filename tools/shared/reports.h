// Prints the results of commands, as text for people and as JSON for scripts. The keys are a contract.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/compare.h"
#include "gi/frame/frame.h"

namespace plumb::cli {

using Json = nlohmann::ordered_json;

// The object as one line-broken text that ends in a newline; bytes that are no UTF-8 are replaced.
std::string json_text(const Json& json);

// Wall time of a run, ms.
struct RunTimes {
    double read_ms = 0;    // reading the scene
    double render_ms = 0;  // planning, and all stages
    double write_ms = 0;   // encoding and writing all files but run.json
    double total_ms = 0;   // from the start until run.json is made; with what else a run does, as --budget and comparing
                           // with the truth. Less than the sum where frames are written while others are rendered
};
void add_times(const RunTimes& times, Json& json);
// The key left_out, a sentence, where the method does not show all of the materials.
void add_left_out(const Scene& scene, const frame::Settings& settings, Json& json);
// "in 120 ms: 5.0 reading, 98.0 rendering, 17.0 writing"
std::string times_text(const RunTimes& times);

// Of run.json: another meaning of a key is another version.
inline constexpr int run_version = 1;

// Everything that a run was made with and what it took.
struct RunReport {
    const Scene& scene;
    const frame::Settings& settings;
    const RunOptions& options;
    const std::vector<frame::StageRun>& stages;
    RunTimes times;
    std::size_t peak_bytes = 0;  // of the whole program
    Json truth = nullptr;        // truth_json(), where something was path traced
    Json radiosity = nullptr;    // radiosity_json(), of that method
};
Json run_json(const RunReport& run);
Json stage_runs_json(const std::vector<frame::StageRun>& stages);
std::string run_text(const RunReport& run);

// Method, layout, seed, pruning and every parameter by table.
Json settings_json(const frame::Settings& settings);

Json plan_json(const Scene& scene, const frame::Settings& settings, const frame::Plan& plan);
std::string plan_text(const frame::Plan& plan);

// The rules by which plans and runs leave work out.
Json rules_json(const std::vector<frame::Rule>& rules);
std::string rules_text(const std::vector<frame::Rule>& rules);

// JSON knows no infinity: null stands for the psnr of equal pictures, which have "equal": true, and for what is
// undefined.
Json compare_json(const compare::Report& report);
std::string compare_text(const compare::Report& report);

Json stages_json(const std::vector<StageInfo>& stages);
std::string stages_text(const std::vector<StageInfo>& stages);

// One component alone, several as an array.
Json components_json(const std::vector<double>& value);
Json explain_json(const frame::Explanation& explanation);
std::string explain_text(const frame::Explanation& explanation);

}  // namespace plumb::cli
