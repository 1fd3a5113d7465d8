#include "gi/frame/frame_graph.h"
#include "gi/parity/stages.h"

namespace plumb::parity {

std::vector<StageData> frame_data(const Scene& scene, const frame::Settings& settings, const frame::Plan& plan,
                                  const frame::Frame& frame) {
    frame::Frame filled = frame;
    frame::FrameGraph graph(scene, settings, filled);
    graph.fill();
    std::vector<StageData> all;
    // What is lent here does not outlive the frame.
    for (const frame::PlannedStage& stage : plan.stages)
        if (stage.needed)
            for (const StageData& data : graph.dispatches(graph.node(stage)))
                all.push_back(owned(find_binding(data.stage, data.label), data));
    return all;
}

}  // namespace plumb::parity
