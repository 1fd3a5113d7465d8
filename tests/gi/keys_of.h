// The keys of a frame's stages, from a run of it: a key is known when what the stage reads is there.
#pragma once

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "gi/frame/frame_graph.h"
#include "gi/frame/kept.h"

namespace plumb::test {

// In the order of the plan's stages.
inline std::vector<graph::Key> keys_of(const Scene& scene, const frame::Settings& settings, Isa isa = Isa::scalar) {
    frame::KeptStages kept;
    RunOptions options;
    options.isa = isa, options.threads = 1;
    std::vector<graph::Key> keys;
    for (const frame::StageRun& run : frame::execute(scene, settings, frame::plan(scene, settings), options, kept).stages)
        keys.push_back(run.key);
    return keys;
}

// A frame, its keys and what its stages made.
struct Ran {
    frame::Plan plan;
    frame::Frame frame;
    std::vector<graph::Key> keys;
    std::map<std::string, Bundle> outputs;  // by label

    Ran(const Scene& scene, const frame::Settings& settings)
        : plan(frame::plan(scene, settings)), frame(frame::execute(scene, settings, plan, {})),
          keys(keys_of(scene, settings)) {
        const frame::FrameGraph graph(scene, settings, frame);
        for (const frame::PlannedStage& s : plan.stages) outputs[s.label] = graph.node(s).outputs();
    }
};

inline bool same_bytes(const Bundle& a, const Bundle& b) {
    return std::equal(a.arrays.begin(), a.arrays.end(), b.arrays.begin(), b.arrays.end(),
                      [](const Array& x, const Array& y) { return x.shape == y.shape && x.bytes == y.bytes; });
}

}  // namespace plumb::test
