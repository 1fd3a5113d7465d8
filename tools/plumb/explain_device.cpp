#include "tools/plumb/explain_device.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "core/error.h"
#include "gi/parity/stages.h"
#include "raster/light_view.h"
#include "tools/plumb/devices.h"
#include "tools/plumb/stage_case.h"
#include "tools/shared/table.h"

#ifdef PLUMB_WITH_VULKAN
#include "tools/vulkan/profile.h"
#include "tools/vulkan/runner.h"
#include "tools/vulkan/shader.h"
#include "tools/vulkan/twins.h"
#endif

namespace plumb::cli {

#ifdef PLUMB_WITH_VULKAN

namespace {

const StageBinding* binding_of(const std::string& stage) {
    const std::vector<StageBinding>& all = parity::bindings();
    const auto binding =
        std::find_if(all.begin(), all.end(), [&](const StageBinding& b) { return b.info.name == stage; });
    return binding == all.end() ? nullptr : &*binding;
}

// A light's maps lie side by side for people; each is a draw of its own. The pixel of this one, if it is there.
std::optional<glm::ivec2> pixel_of(const StageBinding& binding, const StageData& data, const BoundStage& bound,
                                   glm::ivec2 pixel) {
    if (binding.domain != "texel") return bound.writes(pixel) ? std::optional(pixel) : std::nullopt;
    const std::string face = face_of(data);
    const auto* const first = std::begin(raster::face_names);
    const auto index = face.empty() ? 0 : std::find(first, std::end(raster::face_names), face) - first;
    if (pixel.x / data.size.x != int(index)) return {};
    return glm::ivec2(pixel.x % data.size.x, pixel.y);
}

}  // namespace

struct DeviceExplainer::Parts {
    vulkan::Device device;
    const DeviceProfile& profile;
    vulkan::Spirv spirv;

    explicit Parts(const std::string& name)
        : device(vulkan::DeviceOptions{name, false}), profile(vulkan::profile_of(device)) {}

    parity::SideBySide explain(const StageBinding& binding, const StageData& data, const BoundStage& bound,
                               glm::ivec2 pixel) const {
        vulkan::RunTwin options;
        options.tap = pixel;
        options.spirv = spirv;
        const std::vector<TapValue> ours = bound.explain(pixel, profile);
        std::vector<TapValue> theirs = vulkan::run_twin(device, binding, data, options).taps;
        std::vector<std::string> named = vulkan::find_twin(binding.raster ? binding.twin + ".frag" : binding.twin).taps;
        // Where no triangle is seen, no fragment says so.
        if (binding.raster && ours.size() == 1) std::erase(named, "triangle");
        return parity::side_by_side(ours, theirs, named);
    }
};

DeviceExplainer::DeviceExplainer(const std::string& device, const std::string& spirv) {
    try {
        parts_ = std::make_unique<Parts>(device);
    } catch (const vulkan::Error& error) {
        throw InputError(fmt::format("--device {}: {}", device, error.what()));
    }
    if (!spirv.empty()) parts_->spirv = vulkan::load_spirv(spirv);
}

std::vector<DeviceExplanation> DeviceExplainer::explain(const Scene& scene, const frame::Settings& settings,
                                                        const frame::Plan& plan, const frame::Frame& frame,
                                                        const frame::PlannedStage& stage, glm::ivec2 pixel,
                                                        bool required) const {
    const StageBinding* binding = binding_of(stage.name);
    if (!binding) {
        const std::string reason = fmt::format("{} runs on the processor alone: it has no twin", stage.name);
        if (required) throw InputError("--device: " + reason);
        return {{stage.label, pixel, "", "", reason, {}}};
    }
    std::vector<DeviceExplanation> out;
    for (const StageData& data : dispatches(scene, settings, plan, frame, stage)) {
        const std::unique_ptr<BoundStage> bound = binding->bind(data);
        const std::optional<glm::ivec2> own = pixel_of(*binding, data, *bound, pixel);
        if (!own) continue;
        DeviceExplanation one{data.label, pixel, parts_->device.name(), parts_->profile.name, "", {}};
        try {
            one.values = parts_->explain(*binding, data, *bound, *own);
        } catch (const vulkan::Error& error) {
            if (required) throw InputError(fmt::format("{} on {}: {}", data.label, one.device, error.what()));
            one.device.clear(), one.reason = error.what();
        }
        out.push_back(std::move(one));
    }
    if (out.empty()) out.push_back({stage.label, pixel, "", "", "no map of this light serves the pixel", {}});
    return out;
}

#else

struct DeviceExplainer::Parts {};

DeviceExplainer::DeviceExplainer(const std::string&, const std::string&) { require_vulkan("--device"); }

std::vector<DeviceExplanation> DeviceExplainer::explain(const Scene&, const frame::Settings&, const frame::Plan&,
                                                        const frame::Frame&, const frame::PlannedStage&, glm::ivec2,
                                                        bool) const {
    return {};
}

#endif

DeviceExplainer::~DeviceExplainer() = default;

namespace {

std::string sample_text(const parity::TwoValues& line) { return line.sample >= 0 ? std::to_string(line.sample) : ""; }

std::string side_text(const std::optional<std::vector<double>>& value) { return value ? exact_text(*value) : "-"; }

std::string ulp_text(const parity::TwoValues& line) {
    if (!line.compared || !line.ours || !line.theirs) return "-";
    return line.ulp == std::numeric_limits<std::uint64_t>::max() ? "NaN" : std::to_string(line.ulp);
}

std::string summary_text(const parity::SideBySide& values) {
    if (values.compared == 0) return "the device sees nothing here either\n";
    if (!values.parts_at)
        return fmt::format("all {} values are the same bits{}\n", values.compared,
                           values.signs > 0 ? fmt::format(", but for signs of zeros in {}", values.signs) : "");
    const parity::TwoValues& first = values.lines[*values.parts_at];
    const auto differ = std::count_if(values.lines.begin(), values.lines.end(),
                                      [](const parity::TwoValues& l) { return l.compared && !l.same; });
    return fmt::format("they part at {}{}: {} of {} values differ\n", first.name,
                       first.sample >= 0 ? fmt::format(", sample {}", first.sample) : "", differ, values.compared);
}

}  // namespace

std::string summary_text(const DeviceExplanation& e) { return e.device.empty() ? e.reason : summary_text(e.values); }

Json explain_json(const DeviceExplanation& e) {
    Json values = Json::array();
    for (const parity::TwoValues& line : e.values.lines) {
        Json value;
        value["name"] = line.name;
        if (line.sample >= 0) value["sample"] = line.sample;
        value["value"] = line.ours ? components_json(*line.ours) : Json(nullptr);
        value["equation"] = line.equation;
        if (line.compared) value["gpu"] = line.theirs ? components_json(*line.theirs) : Json(nullptr);
        values.push_back(std::move(value));
    }
    Json json = {{"stage", e.stage}, {"pixel", {e.pixel.x, e.pixel.y}}, {"values", std::move(values)}};
    if (e.device.empty()) {
        json["reason"] = e.reason;
        return json;
    }
    json["device"] = e.device;
    json["profile"] = e.profile;
    json["parts_at"] = e.values.parts_at ? Json(*e.values.parts_at) : Json(nullptr);
    return json;
}

std::string explain_text(const DeviceExplanation& e) {
    if (e.device.empty()) return fmt::format("{} at {},{}: {}\n", e.stage, e.pixel.x, e.pixel.y, e.reason);
    std::vector<std::vector<std::string>> rows;
    bool samples = false;
    for (std::size_t i = 0; i < e.values.lines.size(); ++i) {
        const parity::TwoValues& line = e.values.lines[i];
        samples |= line.sample >= 0;
        rows.push_back({sample_text(line), line.name, side_text(line.ours), side_text(line.theirs), ulp_text(line),
                        line.equation, e.values.parts_at == i ? "<-- here they part" : ""});
    }
    std::vector<Column> columns = {{"sample", Align::right}, {"name"},     {"ours"}, {"the device's"},
                                   {"ulp", Align::right},    {"equation"}, {""}};
    if (!samples) {
        columns.erase(columns.begin());
        for (auto& row : rows) row.erase(row.begin());
    }
    return fmt::format("{} at {},{}, on {}, profile {}\n", e.stage, e.pixel.x, e.pixel.y, e.device, e.profile) +
           format_table(columns, rows) + summary_text(e.values);
}

}  // namespace plumb::cli
