#include "tools/shared/scene_command.h"

#include <fmt/format.h>

#include <optional>

#include "gi/frame/idle_settings.h"
#include "gi/frame/mirrors.h"
#include "gi/frame/presets.h"
#include "io/file.h"
#include "io/scene_file.h"
#include "tools/shared/light_sets.h"
#include "tools/shared/progress.h"

namespace plumb::cli {

namespace {

std::string preset_names() {
    std::string names;
    for (const frame::Preset& preset : frame::presets()) names += (names.empty() ? "" : ", ") + preset.name;
    return names;
}

}  // namespace

void add_scene_options(CLI::App& command, SceneOptions& options) {
    command.add_option("scene", options.file, "the scene: .toml, or a bare .obj, .gltf or .glb")->required()->type_name("SCENE");
    command.add_option("--method", options.method, "direct, rsm, isr, probes, radiosity, zbuffer or reference; the scene file's otherwise")
        ->check(some_word())
        ->type_name("M");
    add_preset_option(command, options.preset);
    command.add_option("--set", options.sets, "table.key=value in place of the scene file's, or light.N.on=false: the N-th light, or one of that name; may be repeated")
        ->allow_extra_args(false)
        ->type_name("T.K=V");
    command.add_flag("--strict", options.strict, "refuse a scene whose files lack something: a picture, a library of materials, a material");
    command.add_flag("--no-pruning", options.no_pruning, "run every stage, needed or not: the picture is the same");
}

void add_preset_option(CLI::App& command, std::string& preset) {
    command.add_option("--preset", preset,
                       fmt::format("a document's set-up, whole, in place of the scene file's: {}", preset_names()))
        ->check(some_word())
        ->type_name("NAME");
}

void add_size_option(CLI::App& command, SceneOptions& options) {
    command.add_option("--size", options.size, "pixels, 1024x768 say, in place of the scene's own")
        ->check(some_word())
        ->type_name("WxH");
}

void add_truth_options(CLI::App& command, SceneOptions& options) {
    command.add_flag("--truth", options.truth, "also path trace the scene, and say how far the picture is from it");
    command.add_option("--spp", options.samples, "paths a pixel: reference.samples")
        ->check(some_word())
        ->type_name("N");
    command.add_option("--until-error", options.until_error,
                       "in place of --spp: until the standard error is this part of the mean, 0.01 say")
        ->check(some_word())
        ->type_name("E");
    command.add_option("--rays", options.rays, "native (faster) or exact (the same bits everywhere): reference.rays")
        ->check(some_word())
        ->type_name("R");
}

Scene load(const SceneOptions& options) {
    // A wrong size is told before a large scene is read.
    const std::optional<glm::ivec2> size =
        options.size.empty() ? std::nullopt : std::optional(parse_size("--size", options.size));
    const StatusLine status("reading " + io::shown(options.file));
    Scene scene = io::load_scene(options.file, frame::method_tables(), {options.strict});
    if (size) scene.frame_size = *size;
    switch_lights(options.sets, scene);
    return scene;
}

void note_idle(const SceneOptions& options, const frame::Settings& settings, Scene& scene) {
    for (const std::string& set : options.sets) {
        const Assignment a = parse_assignment(set);
        const std::string reason = frame::idle(settings, scene, a.table, a.key);
        if (!reason.empty()) scene.notes.push_back(fmt::format("{}: changes nothing: {}", a.place, reason));
    }
}

void note_lobes(const frame::Settings& settings, Scene& scene) {
    const std::string left_out = frame::lobes_left_out(scene, settings);
    if (!left_out.empty()) scene.notes.push_back(left_out);
}

void print_notes(const Scene& scene) {
    for (const std::string& note : scene.notes) std::printf("note: %s\n", note.c_str());
    if (!scene.notes.empty()) std::printf("\n");
}

}  // namespace plumb::cli
