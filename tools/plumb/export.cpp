// plumb export: the exact inputs of a stage, and what it should write, to feed a test on a GPU.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <span>

#include "core/content_hash.h"
#include "core/error.h"
#include "gi/frame/filters.h"
#include "gi/frame/isr.h"
#include "gi/frame/frame.h"
#include "gi/parity/stages.h"
#include "io/file.h"
#include "io/manifest.h"
#include "tools/plumb/cli.h"
#include "tools/plumb/devices.h"
#include "tools/plumb/export_readme.h"
#include "tools/plumb/stage_case.h"
#include "tools/shared/options.h"
#include "tools/shared/outputs.h"
#include "tools/shared/progress.h"
#include "tools/shared/reports.h"
#include "tools/shared/scene_command.h"
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

// What a stage wrote; and its discrete choices, [height][width][n], where a twin told them.
struct Made {
    Bundle outputs;
    std::vector<std::int32_t> choices = {};
    int choices_a_pixel = 0;
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

    Made operator()(const StageBinding& binding, const StageData& data) const {
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
        Made made;
        binding.bind(data)->run(options, profile, made.outputs);
        return made;
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

// Files of one export. Inputs of equal bytes are one file: most stages read the same G-buffer.
class Exporter {
  public:
    Exporter(Outputs& outputs, const std::string& folder) : outputs_(outputs), folder_(folder) {}

    // The file of an array that a GPU binds as it is, with what a manifest says about it.
    io::DumpSpec input(const std::string& id, const Slot& slot, const Array& array) {
        const std::pair key(content_hash(array.bytes.data(), array.bytes.size()), array.bytes.size());
        std::string& name = inputs_[key];
        if (name.empty()) {
            name = id + "/in/" + slot.name + ".bin";
            write(name, array.bytes);
        }
        return spec(name, slot, array);
    }
    io::DumpSpec output(const std::string& id, const Slot& slot, const Array& array) {
        const std::string name = id + "/out/" + slot.name + ".bin";
        write(name, array.bytes);
        return spec(name, slot, array);
    }
    // As many channels as a pixel has choices. Every stage that projects to a map makes two; the others none.
    io::DumpSpec choices(const std::string& id, const Made& made, glm::ivec2 size) {
        if (made.choices_a_pixel != 2) return {};
        io::DumpSpec spec;
        spec.vk_format = "R32G32_SINT";
        spec.width = size.x, spec.height = size.y;
        spec.file = write(id + "/out/choices.bin", std::as_bytes(std::span(made.choices)));
        return spec;
    }
    template <class Bytes>
    std::string write(const std::string& name, const Bytes& bytes) {
        outputs_.write(name, [&](const std::string& path) {
            io::write_file(path, {{reinterpret_cast<const char*>(bytes.data()), bytes.size()}});
        });
        bytes_ += bytes.size();
        return folder_ + "/" + name;
    }
    std::size_t bytes() const { return bytes_; }

  private:
    io::DumpSpec spec(const std::string& name, const Slot& slot, const Array& array) const {
        io::DumpSpec spec;
        spec.file = folder_ + "/" + name;
        spec.vk_format = vk_format(slot);
        const std::int64_t texels = std::int64_t(array.bytes.size()) / (4 * slot.channels);
        if (slot.kind == SlotKind::buffer) {
            spec.count = int(texels);
        } else {
            spec.width = int(slot.kind == SlotKind::image_array ? array.shape[2] : array.shape[1]);
            spec.height = int(texels / spec.width);  // layers lie one below the other
        }
        return spec;
    }

    Outputs& outputs_;
    std::string folder_;
    std::map<std::pair<std::uint64_t, std::size_t>, std::string> inputs_;
    std::size_t bytes_ = 0;
};

io::ManifestStage export_stage(const StageBinding& binding, const StageData& data, const std::string& light,
                               const Maker& maker, Exporter& files) {
    io::ManifestStage stage;
    stage.stage = data.stage;
    stage.label = data.label;
    stage.light = light;
    stage.face = face_of(data);
    stage.width = data.size.x;
    stage.height = data.size.y;
    const std::string block = files.write(data.id + "/block.bin", data.uniforms);
    // By name, for people to read and to change; only the file holds what is not finite.
    for (const UniformMember& member : binding.uniforms) {
        const std::vector<double> value = uniform_value(binding, data, member.name);
        if (!std::all_of(value.begin(), value.end(), [](double v) { return std::isfinite(v); })) stage.uniforms_file = block;
        stage.uniforms[member.name] = value;
    }
    if (!stage.uniforms_file.empty()) stage.uniforms.clear();
    if (data.reversed_z) stage.params["reversed_z"] = {"true"};
    for (const Slot& slot : binding.inputs) stage.inputs[slot.name] = files.input(data.id, slot, at(data.inputs, slot.name));
    const Made made = maker(binding, data);
    for (const Slot& slot : binding.outputs)
        stage.outputs[slot.name] = files.output(data.id, slot, at(made.outputs, slot.name));
    stage.choices = files.choices(data.id, made, data.size);
    return stage;
}

// The part of the plan that makes the inputs of what is exported.
frame::Plan needed_by(frame::Plan plan, const std::string& stage) {
    if (stage == "all" || stage == "compose" || stage == "tonemap" || frame::is_filter(stage) || frame::is_isr(stage))
        return plan;
    std::erase_if(plan.stages, [](const frame::PlannedStage& s) {
        return s.name == "compose" || s.name == "tonemap" || frame::is_gather(s.name) ||
               s.name == "filter.upsample" || s.name == "filter.blur" || frame::is_isr(s.name);
    });
    return plan;
}

// Stages of the plan that are exported: those of that name and light which have a twin.
std::vector<frame::PlannedStage> chosen(const frame::Plan& plan, const ExportOptions& given, int light) {
    std::vector<std::string> bound;
    for (const StageBinding& binding : parity::bindings()) bound.push_back(binding.info.name);
    if (given.stage != "all") parity::find_binding(given.stage, "--stage " + given.stage);
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

int run_export(const ExportOptions& given) {
    const RunOptions options = given.common.run_options();
    const Maker maker(given, options);
    const Scene scene = load(given.scene);
    frame::Settings settings = settings_of(scene, given.scene);
    choose_method(settings, given.stage);
    settings.truth = false;
    const int light = given.light.empty() ? -1 : find_light(scene, given.light);
    const frame::Plan plan = frame::plan(scene, settings);
    const std::vector<frame::PlannedStage> stages = chosen(plan, given, light);
    Outputs outputs(given.folder);

    // Render what the stages read, then write one after the other: a big frame's inputs are not held twice.
    const frame::Frame frame = [&] {
        const frame::Plan needed = needed_by(plan, given.stage);
        ProgressBar bar(needed);
        return frame::execute(scene, settings, needed, options, bar.callback());
    }();
    io::Manifest manifest;
    manifest.file = given.folder + "/manifest.toml";
    manifest.device = maker.name();
    manifest.profile = maker.profile.name;
    manifest.subpixel_bits = maker.subpixel_bits();
    Exporter files(outputs, given.folder);
    std::string readme = readme_head(scene.name, maker.name());
    std::vector<std::vector<std::string>> rows;
    bool any_face = false;
    for (const frame::PlannedStage& planned : stages) {
        for (const StageData& data : dispatches(scene, settings, plan, frame, planned)) {
            any_face |= !face_of(data).empty();
            if (!given.face.empty() && !face_of(data).empty() && face_of(data) != given.face) continue;
            const StageBinding& binding = parity::find_binding(data.stage, data.label);
            const std::string name = planned.light >= 0 ? scene.lights[std::size_t(planned.light)].name : "";
            manifest.stages.push_back(export_stage(binding, data, name, maker, files));
            readme += readme_stage(binding, data, manifest.stages.back(), given.folder);
            rows.push_back({data.label, fmt::format("{} x {}", data.size.x, data.size.y), data.id + "/"});
        }
    }
    if (manifest.stages.empty()) throw InputError(fmt::format("--face {}: expected px, nx, py, ny, pz or nz", given.face));
    if (!given.face.empty() && !any_face)
        throw InputError(fmt::format("--face {}: nothing that is exported has faces: expected a point light", given.face));
    files.write("manifest.toml", io::manifest_text(manifest));
    files.write("README.txt", readme);
    outputs.commit();

    if (given.common.json) {
        std::fputs(json_text({{"manifest", manifest.file.string()}, {"stages", rows.size()}, {"bytes", files.bytes()},
                              {"files", outputs.files()}}).c_str(), stdout);
        return success;
    }
    print_notes(scene);
    std::fputs(format_table({{"stage"}, {"size", Align::right}, {"folder"}}, rows).c_str(), stdout);
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
        "`plumb validate` reads. Put your own outputs over those in out/ and validate.");
    command->callback([given, &action] {
        action = [=] {
            if (given->choices && given->device.empty())
                throw InputError("--choices: expected --device, whose twin makes them");
            return run_export(*given);
        };
    });
}

}  // namespace plumb::cli
