// plumb explain: the dispatches and draws of a stage that serve a pixel, with their buffers, for the page and the table of
// samples.
#pragma once

#include <string>
#include <vector>

#include "gi/frame/frame.h"
#include "tools/plumb/explain_page.h"

namespace plumb::cli {

// One dispatch of a stage, and what our kernel's explanation says of it.
struct ExplainedDispatch {
    std::string label;
    glm::ivec2 pixel{0};                    // of its own outputs
    const StageBinding* binding = nullptr;  // null: the stage binds no buffers by name
    StageData data;                         // with the binding
    std::vector<TapValue> values;
};

// A stage's explanation, cut where a point light's next face begins. What no face belongs to goes with the last one.
std::vector<ExplainedDispatch> explained_dispatches(const Scene& scene, const frame::Settings& settings,
                                                    const frame::Frame& frame, const frame::PlannedStage& stage,
                                                    const frame::Explanation& e);

// What the dispatch made, as far as pictures of it are at hand: a draw is drawn once more, others are the frame's.
Bundle made_by(const ExplainedDispatch& dispatch, const frame::PlannedStage& stage, const Scene& scene,
               const frame::Settings& settings, const frame::Frame& frame, const RunOptions& options);

// Source and budget of a stage by its name.
std::string source_of(const std::string& stage);

// Ours alone.
parity::SideBySide one_side(const std::vector<TapValue>& values);

}  // namespace plumb::cli
