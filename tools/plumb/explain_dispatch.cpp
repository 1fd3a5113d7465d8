#include "tools/plumb/explain_dispatch.h"

#include <algorithm>

#include "gi/frame/filters.h"
#include "gi/frame/isr.h"
#include "gi/parity/stages.h"
#include "raster/light_view.h"
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

// rsm.all_rays has no twin; it reads the buffers of rsm.all, and the scene's triangles.
std::vector<StageData> data_of(const Scene& scene, frame::Settings settings, const frame::Plan& plan,
                               const frame::Frame& frame, frame::PlannedStage stage) {
    if (stage.name == "rsm.all_rays") stage.name = "rsm.all", settings.rsm.gather = rsm::Gather::all;
    return dispatches(scene, settings, plan, frame, stage);
}

void copy(Bundle& to, const std::string& name, const Image4& image, glm::ivec2 size) {
    if (glm::ivec2(image.width, image.height) == size) add(to, name, image);
}

}  // namespace

std::vector<ExplainedDispatch> explained_dispatches(const Scene& scene, const frame::Settings& settings,
                                                    const frame::Plan& plan, const frame::Frame& frame,
                                                    const frame::PlannedStage& stage, const frame::Explanation& e) {
    std::vector<StageData> all = data_of(scene, settings, plan, frame, stage);
    std::vector<ExplainedDispatch> out;
    for (Part& part : parts_of(e.values)) {
        ExplainedDispatch one{stage.label, e.pixel, nullptr, {}, std::move(part.values)};
        const std::string face = part.face < 0 ? "" : raster::face_names[part.face];
        if (!face.empty()) one.label += " " + face;
        for (StageData& data : all)
            if (face_of(data) == face) one.binding = binding_of(data.stage), one.data = std::move(data);
        if ((stage.name == "rsm" || stage.name == "shadow.blur") && one.data.size.x > 0) one.pixel.x %= one.data.size.x;
        out.push_back(std::move(one));
    }
    return out;
}

Bundle made_by(const ExplainedDispatch& dispatch, const frame::PlannedStage& stage, const frame::Settings& settings,
               const frame::Frame& frame, const RunOptions& options) {
    if (!dispatch.binding) return {};
    if (dispatch.binding->raster) {
        Bundle outputs = make_outputs(*dispatch.binding, dispatch.data);
        dispatch.binding->bind(dispatch.data)->run(options, {}, outputs);
        return outputs;
    }
    Bundle made;
    const glm::ivec2 size = dispatch.data.size;
    if (stage.name == "direct") copy(made, "irradiance", frame.direct, size);
    if (frame::is_gather(stage.name)) copy(made, "irradiance", frame::gather_sum(frame), size);
    if (frame::is_filter(stage.name))
        copy(made, dispatch.binding->outputs[0].name.c_str(), frame::filter_result(frame, settings, stage), size);
    if (frame::is_isr(stage.name))
        copy(made, dispatch.binding->outputs[0].name.c_str(), frame::isr_result(frame, stage), size);
    if (stage.name == "compose") copy(made, "radiance", frame.radiance, size);
    if (stage.name == "tonemap") copy(made, "display", frame.display, size);
    const std::size_t pixels = std::size_t(size.x) * std::size_t(size.y), first = std::size_t(stage.light) * pixels;
    if (stage.name == "shadow" && frame.visibility.size() >= first + pixels)
        add(made, "visibility", {size.y, size.x}, frame.visibility.data() + first);
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
