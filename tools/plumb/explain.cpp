// plumb explain: every named value of one invocation, and whether it adds up to the picture.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/error.h"
#include "core/nearest_known.h"
#include "io/file.h"
#include "gi/frame/filters.h"
#include "gi/frame/frame_graph.h"
#include "gi/parity/stages.h"
#include "tools/plumb/cli.h"
#include "tools/plumb/devices.h"
#include "tools/plumb/explain_device.h"
#include "tools/plumb/explain_dispatch.h"
#include "tools/shared/file_store.h"
#include "tools/shared/probe_bake.h"
#include "tools/shared/progress.h"
#include "tools/shared/radiosity_report.h"
#include "tools/shared/reports.h"
#include "tools/shared/scene_command.h"
#include "tools/shared/table.h"

namespace plumb::cli {

namespace {

struct ExplainOptions {
    SceneOptions scene;
    Common common;
    std::string stage, pixel, light, device, spirv, html;
    int item = -1;  // below 0: the pixel counts
};

// A value of the picture and the one that the explanation ends with.
struct Check {
    std::string name;
    std::vector<double> picture, explained;

    // A NaN is equal to nothing.
    bool equal() const { return picture == explained; }
};

// The last value of that name; empty where the kernel did not get so far.
std::vector<double> last_value(const frame::Explanation& e, const std::string& name) {
    for (auto v = e.values.rbegin(); v != e.values.rend(); ++v)
        if (v->name == name) return v->value;
    return {};
}

// What the frame goes on with: the result as its target stores it, where the layout rounds it.
std::vector<double> kept_value(const frame::Explanation& e, const std::string& name) {
    const std::vector<double> stored = last_value(e, "stored_" + name);
    return stored.empty() ? last_value(e, name) : stored;
}

struct Checker {
    const Scene& scene;
    const frame::Settings& settings;
    const frame::Plan& plan;
    const frame::Frame& frame;
    const frame::FrameGraph graph{scene, settings, frame};

    // The picture of the indirect light, before it is filtered, is the sum over the lights, in their order: each is
    // rounded as its own target stores it (VRSM fig. 4.4), and added in single precision.
    Check gathered(const frame::Result& result, glm::ivec2 pixel) const {
        glm::vec3 sum(0);
        int lights = 0;
        for (const frame::PlannedStage& s : plan.stages) {
            if (!s.needed || !graph.node(s).adds) continue;
            const auto e = frame::explain(scene, settings, plan, frame, s.name, s.light, pixel);
            const std::vector<double> v = kept_value(e.at(0), result.tap);
            sum += glm::vec3(v.at(0), v.at(1), v.at(2));
            ++lights;
        }
        const glm::vec4& v = frame::gather_sum(frame)(pixel.x, pixel.y);
        return {lights > 1 ? fmt::format("{}, the sum of {} lights", result.name, lights) : result.name,
                {v.x, v.y, v.z}, {sum.x, sum.y, sum.z}};
    }

    // What the stage wrote, beside what the explanation says it wrote; not where the output was not wanted.
    std::vector<Check> checks(const frame::PlannedStage& s, const frame::Explanation& e) const {
        const frame::PlannedNode& node = graph.node(s);
        const Bundle outputs = node.outputs();
        std::vector<Check> all;
        for (const frame::Result& result : node.results) {
            if (node.adds) return {gathered(result, e.pixel)};
            const std::vector<double> explained =
                result.stored ? kept_value(e, result.tap) : last_value(e, result.tap);
            const std::vector<double> picture = value_at(node, outputs, result, e.pixel);
            if (explained.empty() && result.where_seen) continue;
            if (!picture.empty()) all.push_back({result.name, picture, explained});
        }
        return all;
    }

    // A light's maps lie side by side, each an output of its own.
    std::vector<double> value_at(const frame::PlannedNode& node, const Bundle& outputs, const frame::Result& result,
                                 glm::ivec2 item) const {
        const Array* array = find(outputs, result.output);
        if (!array) {
            const int side = node.size().y;
            array = find(outputs, std::string(raster::face_names[item.x / side]) + "." + result.output);
            item.x %= side;
        }
        if (!array || array->bytes.empty()) return {};
        // A list has a row an item; an image, rows of them.
        const glm::ivec2 size = node.size();
        const bool list = array->shape.size() == 2 && array->shape[0] == std::int64_t(size.x) * size.y;
        const std::size_t channels = list ? std::size_t(array->shape[1]) : array->shape.size() == 3 ? std::size_t(array->shape[2]) : 1;
        const std::size_t at = std::size_t(item.y) * std::size_t(list ? size.x : array->shape[1]) + std::size_t(item.x);
        const auto* values = reinterpret_cast<const float*>(array->bytes.data()) + at * channels + std::size_t(result.channel);
        return {values, values + result.count};
    }
};

const frame::PlannedStage& planned(const frame::Plan& plan, const std::string& label) {
    return *std::find_if(plan.stages.begin(), plan.stages.end(),
                         [&](const frame::PlannedStage& s) { return s.label == label; });
}

std::string check_text(const Check& check) {
    return fmt::format("check: {}: explained {}, in the picture {}: {}\n", check.name, exact_text(check.explained),
                       exact_text(check.picture), check.equal() ? "equal" : "NOT EQUAL");
}

// Without what comes after a bounce, where `stage` does not stand on it.
frame::Plan up_to(frame::Plan plan, const Scene& scene, const frame::Settings& settings, const std::string& stage) {
    const frame::FrameGraph graph(scene, settings, Geometry{});
    const bool direct = std::any_of(graph.nodes().begin(), graph.nodes().end(), [&](const frame::PlannedNode& node) {
        return node.direct && node.plan.name == stage;
    });
    if (direct) std::erase_if(plan.stages, [&](const frame::PlannedStage& s) { return !graph.node(s).direct; });
    return plan;
}

// Whether its items are texels of a light's maps.
bool of_maps(const std::string& stage) {
    const std::vector<StageBinding>& all = parity::bindings();
    return std::any_of(all.begin(), all.end(),
                       [&](const StageBinding& b) { return b.info.name == stage && b.domain == "texel"; });
}

// Whether its items are pixels of the frame; how many others there are the frame knows.
bool of_pixels(const std::string& stage, const Scene& scene, const frame::Settings& settings) {
    if (stage.empty()) return true;
    const frame::FrameGraph graph(scene, settings, Geometry{});
    const auto named = [&](const frame::PlannedNode& node) { return node.plan.name == stage; };
    const auto node = std::find_if(graph.nodes().begin(), graph.nodes().end(), named);
    return node == graph.nodes().end() || node->of_pixels;
}

// What cannot be explained is refused before the frame is rendered.
void require_explainable(const ExplainOptions& given, glm::ivec2 pixel, const Scene& scene, const frame::Settings& settings) {
    std::vector<std::string> names;
    for (const StageInfo& s : frame::all_stages()) names.push_back(s.name);
    if (!given.stage.empty() && std::find(names.begin(), names.end(), given.stage) == names.end())
        throw InputError(fmt::format("--stage {}: unknown stage{}", given.stage, nearest_known(given.stage, names)));
    if (!given.stage.empty() && !frame::in_a_frame(given.stage))
        throw InputError(fmt::format("--stage {}: the stage is not part of a frame: no method runs it", given.stage));
    if (given.stage == "reference")
        throw InputError("--stage reference: it is a mean over paths; it has no values to list");
    if (!of_maps(given.stage) && of_pixels(given.stage, scene, settings) && (pixel.x >= scene.frame_size.x || pixel.y >= scene.frame_size.y))
        throw InputError(fmt::format("--pixel {}: outside of the picture, which is {} x {}", given.pixel,
                                     scene.frame_size.x, scene.frame_size.y));
}

// What is printed, and the page, stage by stage.
class Report {
  public:
    Report(const ExplainOptions& given, const RunOptions& options, const Scene& scene, const frame::Settings& settings,
           const frame::Frame& frame, glm::ivec2 pixel)
        : given_(given), options_(options), scene_(scene), settings_(settings), frame_(frame) {
        if (given.html.empty()) return;
        page_.emplace(fmt::format("plumb explain {}, {}", io::shown(scene.name),
                                  given.item >= 0 ? fmt::format("item {}", given.item)
                                                  : fmt::format("{} {},{}", of_maps(given.stage) ? "texel" : "pixel", pixel.x, pixel.y)));
        // An item is at no place of the picture.
        if (given.item < 0 && !of_maps(given.stage) && !frame.display.empty()) page_->picture(frame.display, pixel);
    }

    void add(const frame::PlannedStage& stage, const frame::Explanation& e, const std::vector<Check>& checks) {
        stages_.push_back(explain_json(e));
        std::vector<std::string> notes;
        for (const Check& check : checks) notes.push_back(check_text(check));
        const bool sampled = std::any_of(e.values.begin(), e.values.end(), [](const TapValue& v) { return v.sample >= 0; });
        std::vector<ExplainedDispatch> dispatches;
        if (page_ || (sampled && !given_.common.json)) dispatches = explained_dispatches(scene_, settings_, frame_, stage, e);
        // Every value, of each dispatch the samples that bring most first; JSON keeps the kernel's order.
        frame::Explanation ordered{e.stage, e.pixel, dispatches.empty() ? e.values : std::vector<TapValue>{}};
        for (const ExplainedDispatch& one : dispatches)
            for (TapValue& v : by_contribution(one.values)) ordered.values.push_back(std::move(v));
        text_ += (text_.empty() ? "" : "\n") + explain_text(ordered);
        for (const ExplainedDispatch& one : dispatches) {
            text_ += samples_text(one.values, sample_shape(one.binding, &one.data, one.pixel));
            if (page_) add_section(stage, one, "", one_side(one.values), notes);
        }
        for (const std::string& note : notes) text_ += note;
    }

    void add(const frame::PlannedStage& stage, const frame::Explanation& e, const DeviceExplanation& d) {
        text_ += (text_.empty() ? "" : "\n") + explain_text(d);
        stages_.push_back(explain_json(d));
        if (!page_) return;
        std::vector<ExplainedDispatch> all = explained_dispatches(scene_, settings_, frame_, stage, e);
        for (ExplainedDispatch& one : all)
            if (d.device.empty() || one.label == d.stage || one.data.label == d.stage)
                return add_section(stage, one, d.device, d.device.empty() ? one_side(one.values) : d.values,
                                   {summary_text(d)});
    }

    void write() const {
        if (page_) io::write_text(given_.html, page_->html());
    }
    const std::string& text() const { return text_; }
    const Json& stages() const { return stages_; }

  private:
    void add_section(const frame::PlannedStage& stage, const ExplainedDispatch& one, const std::string& device,
                     const parity::SideBySide& values, const std::vector<std::string>& notes) {
        const Bundle outputs = made_by(one, stage, scene_, settings_, frame_, options_);
        const frame::FrameGraph graph(scene_, settings_, frame_);
        const frame::PlannedNode& node = graph.node(stage);
        page_->add({one.label, source_of(stage.name), one.pixel, one.binding, &one.data, &outputs, values, device, notes,
                    node.pictures ? node.pictures(one.pixel) : std::vector<frame::ItemPicture>{}, given_.item >= 0});
    }

    const ExplainOptions& given_;
    const RunOptions& options_;
    const Scene& scene_;
    const frame::Settings& settings_;
    const frame::Frame& frame_;
    std::optional<ExplainPage> page_;
    std::string text_;
    Json stages_ = Json::array();
};

int explain(const ExplainOptions& given) {
    const RunOptions options = given.common.run_options();
    const glm::ivec2 pixel = given.item < 0 ? parse_pixel(given.pixel) : glm::ivec2(given.item, 0);
    Scene scene = load(given.scene);
    frame::Settings settings = settings_of(scene, given.scene);
    scene = drawn(std::move(scene), settings, options);
    const int light = given.light.empty() ? -1 : find_light(scene, given.light);
    require_explainable(given, pixel, scene, settings);
    frame::plan(scene, settings);  // what cannot be rendered is told before a bake is made for it
    add_bake(scene, settings, {options, given.scene.no_cache ? "" : cache_folder(), !given.common.json});
    const frame::Plan plan = up_to(frame::plan(scene, settings), scene, settings, given.stage);
    std::unique_ptr<DeviceExplainer> device;
    if (!given.device.empty()) device = std::make_unique<DeviceExplainer>(given.device, given.spirv);
    const std::unique_ptr<FileStore> rows = row_files(settings, given.scene.no_cache);
    const frame::Frame frame = [&] {
        ProgressBar bar(plan);
        return frame::execute(scene, settings, plan, options, bar.callback(), {nullptr, rows.get()});
    }();

    // Explain: hold each stage's last value against the picture, or all of them against the device's.
    const auto explanations = frame::explain(scene, settings, plan, frame, given.stage, light, pixel);
    const frame::Plan ran = frame::plan_after_run(plan, frame);
    const Checker checker{scene, settings, ran, frame};
    Report report(given, options, scene, settings, frame, pixel);
    std::vector<Check> wrong;
    bool parted = false;
    for (const frame::Explanation& e : explanations) {
        const frame::PlannedStage& stage = planned(plan, e.stage);
        if (!device) {
            const std::vector<Check> checks = checker.checks(stage, e);
            report.add(stage, e, checks);
            for (const Check& check : checks)
                if (!check.equal()) wrong.push_back(check);
            continue;
        }
        // The picture is not the device's, so that nothing is to be checked against it.
        for (const DeviceExplanation& d :
             device->explain(scene, settings, plan, frame, stage, pixel, !given.stage.empty())) {
            report.add(stage, e, d);
            parted |= d.values.parts_at.has_value();
        }
    }
    report.write();
    if (given.common.json) {
        const Json& stages = report.stages();
        const Json all = {{"pixel", {pixel.x, pixel.y}}, {"stages", stages}};
        std::fputs(json_text(given.stage.empty() || stages.size() > 1 ? all : stages.at(0)).c_str(), stdout);
    } else {
        print_notes(scene);
        std::fputs(report.text().c_str(), stdout);
    }
    for (const Check& check : wrong) std::fprintf(stderr, "plumb: %s", check_text(check).c_str());
    return wrong.empty() && !parted ? success : disagreement;
}

}  // namespace

void add_explain(CLI::App& program, Action& action) {
    auto given = std::make_shared<ExplainOptions>();
    CLI::App* command = program.add_subcommand("explain", "list every named value of one pixel, with its equation");
    add_scene_options(*command, given->scene);
    add_size_option(*command, given->scene);
    command->add_option("--stage", given->stage, "a name of `plumb stages`; all but rsm otherwise")->type_name("S");
    command->add_option("--pixel", given->pixel, "from the top left; of the light's map for the stage rsm: the six\n"
                        "of a point light lie side by side, +x -x +y -y +z -z")
        ->type_name("X,Y");
    command->add_option("--item", given->item, "in its place of a stage over a list (elements): the number from 0")
        ->check(number_within(0, 1 << 30))
        ->type_name("N");
    command->add_option("--light", given->light, "the light, for a stage that runs once a light; the first otherwise")
        ->type_name("NAME");
    add_device_option(*command, given->device);
    command->add_option("--spirv", given->spirv, "runs in place of the stage's tapped twin (its fragment stage), with\n"
                        "the same taps: the twin of a broken shader, say")
        ->check(some_word())
        ->type_name("FILE");
    command->add_option("--html", given->html, "also write a page: the buffers as pictures, the samples on them, the\n"
                        "numbers beside them")
        ->type_name("FILE");
    add_common(*command, given->common);
    command->footer(
        "Each stage ends with a check: is its last value what the picture holds? Exit code 1 if not.\n"
        "Behind a gather's values stands what each sample brings: weight visibility flux form.\n"
        "With --device the twin's values stand beside ours instead; the first that differs is marked: exit code 1.\n"
        "In JSON {stage, pixel, values}; without --stage, and where a point light takes several dispatches of it,\n"
        "{pixel, stages: [of these]}. With --device values have \"gpu\"; parts_at: the first that differs, from 0.");
    command->callback([given, &action] {
        action = [=] {
            if (!given->spirv.empty() && (given->device.empty() || given->stage.empty()))
                throw InputError("--spirv: expected --device and --stage: where it runs, and in place of what");
            if (given->pixel.empty() == (given->item < 0)) throw InputError("expected --pixel X,Y, or --item N of a stage over a list");
            if (given->item >= 0 && given->stage.empty()) throw InputError("--item: expected --stage: which list it is of");
            return explain(*given);
        };
    });
}

}  // namespace plumb::cli
