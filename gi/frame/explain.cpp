#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/error.h"
#include "core/nearest_known.h"
#include "gi/frame/frame_graph.h"

namespace plumb::frame {

namespace {

void require_inside(const std::string& label, glm::ivec2 pixel, glm::ivec2 size) {
    if (pixel.x < 0 || pixel.y < 0 || pixel.x >= size.x || pixel.y >= size.y)
        throw InputError(fmt::format("explain: pixel {},{} is outside of {}, which is {} x {}", pixel.x, pixel.y, label,
                                     size.x, size.y));
}

}  // namespace

std::vector<Explanation> explain(const Scene& scene, const Settings& settings, const Plan& plan, const Frame& frame,
                                 const std::string& stage, int light, glm::ivec2 pixel) {
    // Find the stages that are asked for.
    std::vector<std::string> names;
    for (const StageInfo& info : all_stages()) names.push_back(info.name);
    if (!stage.empty() && std::find(names.begin(), names.end(), stage) == names.end())
        throw InputError(fmt::format("explain: unknown stage '{}'{}", stage, nearest_known(stage, names)));
    if (!stage.empty() && !in_a_frame(stage))
        throw InputError(fmt::format("explain: the stage {} is not part of a frame: no method runs it", stage));
    if (stage == reference::info().name)
        throw InputError(fmt::format("explain: the stage {} is a mean over paths; it has no values to list", stage));
    const FrameGraph graph(scene, settings, frame);
    std::vector<const PlannedNode*> chosen;
    std::string left_out;
    std::vector<std::string> explained;  // what could have been asked for, each once
    bool of_host = false;
    for (const PlannedStage& s : plan_after_run(plan, frame).stages) {
        const PlannedNode& node = graph.node(s);
        if (s.needed && node.explain && node.by_name && std::find(explained.begin(), explained.end(), s.name) == explained.end())
            explained.push_back(s.name);
        if (!stage.empty() && s.name != stage) continue;
        of_host = of_host || !node.explain;
        if (!node.explain || !(stage.empty() ? node.of_pixels : node.by_name)) continue;
        if (light >= 0 && s.light >= 0 && s.light != light) continue;
        if (!s.needed) {
            left_out = s.reason;
            continue;
        }
        chosen.push_back(&node);
        if (stage.empty()) continue;
        if (!node.in_steps) break;
        if (s.light >= 0) light = s.light;
    }
    if (chosen.empty() && of_host && !stage.empty())
        throw InputError(fmt::format("explain: the stage {} is a step of the host, without items; it has no values to list", stage));
    if (chosen.empty() && left_out.empty())
        left_out = explained.empty() ? "its method does not use it" : fmt::format("its method runs {}", fmt::join(explained, ", "));
    if (chosen.empty())
        throw InputError(fmt::format("explain: {} does not run for this scene: {}", stage.empty() ? "any stage" : stage, left_out));

    std::vector<Explanation> explanations;
    for (const PlannedNode* node : chosen) {
        const glm::ivec2 size = node->size();
        // Of all stages at a pixel those of half size are asked for the one that stands for it.
        if (stage.empty()) require_inside("the frame", pixel, scene.frame_size);
        const glm::ivec2 at = stage.empty() && size != scene.frame_size ? pixel / 2 : pixel;
        require_inside(node->plan.label, at, size);
        explanations.push_back({node->plan.label, at, node->explain(at)});
    }
    return explanations;
}

}  // namespace plumb::frame
