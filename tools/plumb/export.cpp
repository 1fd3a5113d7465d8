// plumb export: the exact inputs of a stage, what it should write, and where to write it, to feed a test on a GPU.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "core/content_hash.h"
#include "core/error.h"
#include "gi/frame/frame_graph.h"
#include "gi/parity/stages.h"
#include "io/file.h"
#include "io/filling.h"
#include "io/manifest.h"
#include "tools/plumb/cli.h"
#include "tools/plumb/devices.h"
#include "tools/plumb/export_files.h"
#include "tools/plumb/export_merge.h"
#include "tools/plumb/export_readme.h"
#include "tools/plumb/export_settings.h"
#include "tools/plumb/memory_need.h"
#include "tools/plumb/stage_case.h"
#include "tools/shared/file_store.h"
#include "tools/shared/options.h"
#include "tools/shared/outputs.h"
#include "tools/shared/probe_bake.h"
#include "tools/shared/process_memory.h"
#include "tools/shared/progress.h"
#include "tools/shared/radiosity_report.h"
#include "tools/shared/reports.h"
#include "tools/shared/scene_command.h"
#include "tools/shared/sweep.h"
#include "tools/shared/table.h"

#ifdef PLUMB_WITH_VULKAN
#include "tools/vulkan/profile.h"
#include "tools/vulkan/runner.h"
#endif

namespace plumb::cli {

namespace {

struct ExportOptions {
    SceneOptions scene;
    Common common;
    std::string stage, light, face, folder, profile, device;
    bool choices = false;
};

// What makes the outputs: our kernels, or a twin on a device.
struct Maker {
    const RunOptions& options;
    const bool choices;
    DeviceProfile profile;  // as given; else the device's; else ideal
#ifdef PLUMB_WITH_VULKAN
    std::unique_ptr<vulkan::Device> device;
#endif

    Maker(const ExportOptions& given, const RunOptions& run) : options(run), choices(given.choices) {
        if (!given.profile.empty()) profile = find_profile(given.profile, "--profile " + given.profile);
        if (given.device.empty()) return;
        require_vulkan("--device");
#ifdef PLUMB_WITH_VULKAN
        try {
            device = std::make_unique<vulkan::Device>(vulkan::DeviceOptions{given.device, false});
            if (given.profile.empty()) profile = vulkan::profile_of(*device);
        } catch (const vulkan::Error& error) {
            throw InputError(fmt::format("--device {}: {}", given.device, error.what()));
        }
#endif
    }

    // What the twin wrote on the device; nothing without one.
    MadeOutputs operator()(const StageBinding& binding, const StageData& data) const {
#ifdef PLUMB_WITH_VULKAN
        try {
            if (device) {
                vulkan::RunTwin how;
                how.choices = choices;
                vulkan::TwinResult made = vulkan::run_twin(*device, binding, data, how);
                return {std::move(made.outputs), std::move(made.choices), made.choices_a_pixel};
            }
        } catch (const vulkan::Error& error) {
            throw InputError(fmt::format("{} on {}: {}", data.label, device->name(), error.what()));
        }
#endif
        return {};
    }

    // What our kernels make of it, whatever runs the outputs.
    Bundle expected(const StageBinding& binding, const StageData& data) const {
        Bundle outputs;
        binding.bind(data)->run(options, profile, outputs);
        return outputs;
    }

    // What the device says of itself, where no profile does; else 0.
    int subpixel_bits() const {
#ifdef PLUMB_WITH_VULKAN
        if (device && profile.name == "ideal") return int(std::min(device->limits().subPixelPrecisionBits, 16u));
#endif
        return 0;
    }

    std::string name() const {
#ifdef PLUMB_WITH_VULKAN
        if (device) return device->name();
#endif
        return "";
    }
};

// The part of the plan that makes the inputs of what is exported: of what stands before a bounce, and of what gathers it, no
// more than that.
frame::Plan needed_by(frame::Plan plan, const Scene& scene, const frame::Settings& settings, const std::string& stage) {
    const frame::FrameGraph graph(scene, settings, Geometry{});
    const bool early = std::any_of(graph.nodes().begin(), graph.nodes().end(), [&](const frame::PlannedNode& node) {
        return node.plan.name == stage && (node.direct || node.adds);
    });
    if (early) std::erase_if(plan.stages, [&](const frame::PlannedStage& s) { return !graph.node(s).direct; });
    return plan;
}

// Stages of the plan that are exported: those of that name and light which have a twin.
std::vector<frame::PlannedStage> chosen(const frame::Plan& plan, const ExportOptions& given, int light) {
    std::vector<std::string> bound;
    for (const StageBinding& binding : parity::bindings()) bound.push_back(binding.info.name);
    std::vector<frame::PlannedStage> stages;
    std::string why_not = "the scene's method does not run it";
    for (const frame::PlannedStage& s : plan.stages) {
        if (given.stage != "all" && s.name != given.stage) continue;
        if (light >= 0 && s.light >= 0 && s.light != light) continue;
        if (std::find(bound.begin(), bound.end(), s.name) == bound.end()) continue;
        if (s.needed)
            stages.push_back(s);
        else
            why_not = "it is left out: " + s.reason + "; --no-pruning runs it all the same";
    }
    if (stages.empty()) throw InputError(fmt::format("--stage {}: {}", given.stage, why_not));
    return stages;
}

// The same whenever scene, settings, device and profile are: not of the time, the folder or what is exported of them.
std::uint64_t export_id(const Scene& scene, const frame::Settings& settings, const Maker& maker) {
    std::string text = json_text(settings_json(settings)) + maker.name() + "\n" + maker.profile.name;
    for (const Light& light : scene.lights) text += fmt::format("\n{} {}", light.name, light.radius);
    return content_hash(text, scene_hash(scene));
}

// What became of the export that was in the folder.
void print_merge(const Merge& merge, const std::vector<std::string>& changed) {
    if (!merge.kept.empty())
        fmt::print("beside them, of the earlier export of the same scene and settings: {}\n", fmt::join(merge.kept, ", "));
    if (!merge.removed.empty())
        fmt::print("replaced: what was there is of another scene, other settings, another device or program; gone: {}\n",
                   fmt::join(merge.removed, ", "));
    for (const std::string& file : changed) fmt::print("kept: {}: has changed since it was exported\n", io::shown(file));
}

int run_export(const ExportOptions& given) {
    const RunOptions options = given.common.run_options();
    const Maker maker(given, options);
    Scene scene = load(given.scene);
    frame::Settings settings = settings_of(scene, given.scene);
    scene = drawn(std::move(scene), settings, options);
    const std::uint64_t id = export_id(scene, settings, maker);
    const int light = given.light.empty() ? -1 : find_light(scene, given.light);
    if (given.stage != "all") {
        parity::find_binding(given.stage, "--stage " + given.stage);
        const frame::Settings asked = settings;
        settings = frame::settings_running(asked, given.stage);
        for (const std::string& note : replaced_settings(asked, settings, given.stage, given.scene)) scene.notes.push_back(note);
    }
    if (given.stage == "all" || given.stage == rsm::stage_name(settings.rsm)) require_whole_rows(settings);
    settings.truth = false;
    frame::plan(scene, settings);  // what cannot be rendered is told before a bake is made for it
    add_bake(scene, settings, {options, given.scene.no_cache ? "" : cache_folder(), !given.common.json});
    const frame::Plan plan = frame::plan(scene, settings);
    const std::vector<frame::PlannedStage> stages = chosen(plan, given, light);
    require_memory(fmt::format("export of {} x {} pixels", scene.frame_size.x, scene.frame_size.y),
                   bytes_to_export(frame::FrameGraph(scene, settings, Geometry{}), stages, int(scene.lights.size())), memory_there(),
                   "expected a smaller --size");
    const std::optional<io::Manifest> earlier = earlier_export(given.folder);
    Outputs outputs(given.folder);

    // Render what the stages read, then write one after the other: a big frame's inputs are not held twice.
    const std::unique_ptr<FileStore> row_store = row_files(settings, given.scene.no_cache);
    frame::Frame frame = [&] {
        const frame::Plan needed = needed_by(plan, scene, settings, given.stage);
        ProgressBar bar(needed);
        return frame::execute(scene, settings, needed, options, bar.callback(), {nullptr, row_store.get()});
    }();
    io::Manifest manifest;
    manifest.file = given.folder + "/manifest.toml";
    manifest.device = maker.name();
    manifest.profile = maker.profile.name;
    manifest.subpixel_bits = maker.subpixel_bits();
    manifest.exported.id = hash_text(id);
    ExportFiles files(outputs, given.folder, io::filling_word(id));
    ExportReadme readme(scene.name, maker.name());
    std::vector<std::vector<std::string>> rows;
    bool any_face = false;
    frame::FrameGraph graph(scene, settings, frame);
    graph.fill();
    for (const frame::PlannedStage& planned : stages) {
        for (const StageData& lent : graph.dispatches(graph.node(planned))) {
            any_face |= !face_of(lent).empty();
            if (!given.face.empty() && !face_of(lent).empty() && face_of(lent) != given.face) continue;
            const StageBinding& binding = parity::find_binding(lent.stage, lent.label);
            const StageData data = owned(binding, lent);
            const std::string name = planned.light >= 0 ? scene.lights[std::size_t(planned.light)].name : "";
            manifest.stages.push_back(export_stage(binding, data, name, maker.expected(binding, data), maker(binding, data), files));
            readme.add(binding, data, manifest.stages.back(), given.folder);
            rows.push_back({data.label, fmt::format("{} x {}", data.size.x, data.size.y), data.id + "/"});
        }
    }
    if (manifest.stages.empty()) throw InputError(fmt::format("--face {}: expected px, nx, py, ny, pz or nz", given.face));
    if (!given.face.empty() && !any_face)
        throw InputError(fmt::format("--face {}: nothing that is exported has faces: expected a point light", given.face));
    manifest.exported.files = files.hashes();
    Merge merge;
    if (earlier) merge = merge_exports(*earlier, manifest);
    if (earlier) readme.keep(given.folder + "/README.txt", merge.kept);
    const std::string text = readme.text(), manifest_text = io::manifest_text(manifest);
    files.write("README.txt", text.data(), text.size());
    files.write("manifest.toml", manifest_text.data(), manifest_text.size());
    outputs.commit();
    std::vector<std::string> changed;
    if (earlier) changed = remove_stale(*earlier, merge);

    if (given.common.json) {
        std::fputs(json_text({{"manifest", manifest.file.string()}, {"stages", rows.size()}, {"bytes", files.bytes()},
                              {"export", manifest.exported.id}, {"kept", merge.kept}, {"replaced", merge.removed},
                              {"changed", changed}, {"notes", scene.notes}, {"files", outputs.files()}}).c_str(), stdout);
        return success;
    }
    print_notes(scene);
    std::fputs(format_table({{"stage"}, {"size", Align::right}, {"folder"}}, rows).c_str(), stdout);
    print_merge(merge, changed);
    std::printf("\nwrote %s, %zu files, %s MB\n", manifest.file.string().c_str(), outputs.files().size(),
                megabytes_text(files.bytes()).c_str());
    return success;
}

}  // namespace

void add_export(CLI::App& program, Action& action) {
    auto given = std::make_shared<ExportOptions>();
    CLI::App* command =
        program.add_subcommand("export", "write a stage's inputs, and what it should write, for a GPU test");
    add_scene_options(*command, given->scene);
    add_size_option(*command, given->scene);
    command->add_option("--stage", given->stage, "a name of `plumb stages`, or all: every dispatch of the frame")
        ->required()
        ->type_name("S");
    command->add_option("--light", given->light, "of a stage that runs once a light; every light otherwise")
        ->type_name("NAME");
    command->add_option("--face", given->face, "of a point light: px, nx, py, ny, pz or nz; all six otherwise")
        ->type_name("F");
    command->add_option("--profile", given->profile, "how the device rounds that the outputs are meant for;\n"
                        "otherwise that of --device as its driver is known, or ideal")
        ->check(some_word())
        ->type_name("P");
    add_device_option(*command, given->device);
    command->add_flag("--choices", given->choices, "with --device: also write which texels the twin chose, for\n"
                      "`plumb validate` to follow. They are that twin's: another shader's outputs want its own");
    command->add_option("-o,--output", given->folder, "the folder to write to")->required()->type_name("DIR");
    add_common(*command, given->common);
    command->footer(
        "Buffers and images are raw, as a GPU binds them; README.txt lists the bindings, manifest.toml is what\n"
        "`plumb validate` reads. out/ is filled with what no pass writes, expected/ holds the answer: write your outputs over\n"
        "out/ and validate. What is exported of one scene with the same settings into the same folder stands in one\n"
        "manifest; of another, or with others, it replaces what was there.");
    command->callback([given, &action] {
        action = [=] {
            if (given->choices && given->device.empty())
                throw InputError("--choices: expected --device, whose twin makes them");
            return run_export(*given);
        };
    });
}

}  // namespace plumb::cli
