#include "tools/plumb/explain_dispatch.h"

#include <algorithm>

#include "gi/frame/frame_graph.h"
#include "gi/parity/stages.h"
#include "tools/plumb/stage_case.h"

namespace plumb::cli {

namespace {

const StageBinding* binding_of(const std::string& stage) {
    const std::vector<StageBinding>& all = parity::bindings();
    const auto at = std::find_if(all.begin(), all.end(), [&](const StageBinding& b) { return b.info.name == stage; });
    return at == all.end() ? nullptr : &*at;
}

// What was explained of one face; of a light with one map all of it.
struct Part {
    int face = -1;
    std::vector<TapValue> values;
};

std::vector<Part> parts_of(const std::vector<TapValue>& values) {
    std::vector<Part> parts;
    for (const TapValue& v : values) {
        const bool face = v.name == "face" && v.sample < 0;
        if (parts.empty() || (face && parts.back().face >= 0)) parts.emplace_back();
        if (face) parts.back().face = int(v.value.at(0));
        parts.back().values.push_back(v);
    }
    return parts;
}

}  // namespace

std::vector<ExplainedDispatch> explained_dispatches(const Scene& scene, const frame::Settings& settings,
                                                    const frame::Frame& frame, const frame::PlannedStage& stage,
                                                    const frame::Explanation& e) {
    const frame::FrameGraph graph(scene, settings, frame);
    const frame::PlannedNode& node = graph.node(stage);
    const std::vector<StageData> all = node.like ? node.like() : graph.dispatches(node);
    std::vector<ExplainedDispatch> out;
    for (Part& part : parts_of(e.values)) {
        ExplainedDispatch one{stage.label, e.pixel, nullptr, {}, std::move(part.values)};
        const std::string face = part.face < 0 ? "" : raster::face_names[part.face];
        if (!face.empty()) one.label += " " + face;
        for (const StageData& data : all) {
            if ((node.like ? data.id : face_of(data)) != face) continue;
            one.binding = binding_of(data.stage), one.data = owned(*one.binding, data);
        }
        // A light's maps lie side by side.
        if (one.data.size.x > 0) one.pixel.x %= one.data.size.x;
        out.push_back(std::move(one));
    }
    return out;
}

Bundle made_by(const ExplainedDispatch& dispatch, const frame::PlannedStage& stage, const Scene& scene,
               const frame::Settings& settings, const frame::Frame& frame, const RunOptions& options) {
    if (!dispatch.binding) return {};
    if (dispatch.binding->raster) {
        Bundle outputs = make_outputs(*dispatch.binding, dispatch.data);
        dispatch.binding->bind(dispatch.data)->run(options, {}, outputs);
        return outputs;
    }
    Bundle made;
    const frame::FrameGraph graph(scene, settings, frame);
    const Bundle outputs = graph.node(stage).outputs();
    for (const Slot& slot : dispatch.binding->outputs) {
        const Array* array = find(outputs, slot.name);
        if (!array || array->shape.size() < 2 || array->bytes.empty()) continue;
        if (array->shape[0] == dispatch.data.size.y && array->shape[1] == dispatch.data.size.x) made.arrays.push_back(*array);
    }
    for (Array& array : made.arrays) array.bytes.own();
    return made;
}

std::string source_of(const std::string& stage) {
    for (const StageInfo& info : frame::all_stages())
        if (info.name == stage) return info.source;
    return "";
}

parity::SideBySide one_side(const std::vector<TapValue>& values) {
    parity::SideBySide out;
    for (const TapValue& v : values) out.lines.push_back({v.name, v.sample, v.equation, v.value, {}, false});
    return out;
}

}  // namespace plumb::cli
