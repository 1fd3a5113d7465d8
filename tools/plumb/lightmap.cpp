// plumb lightmap: the truth of a lightmap, path traced at every receiver.
#include "tools/plumb/lightmap.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/fields.h"
#include "core/nearest_known.h"
#include "gi/probes/own_layout.h"
#include "io/exr_attributes.h"
#include "io/file.h"
#include "io/scene_file.h"
#include "tools/plumb/cli.h"
#include "tools/shared/outputs.h"
#include "tools/shared/probe_bake.h"
#include "tools/shared/progress.h"
#include "tools/shared/reports.h"
#include "tools/shared/scene_command.h"

namespace plumb::cli {

namespace {

const std::vector<std::string> parts = {"all", "direct", "one_bounce", "indirect"};  // as reference::Mode counts them

reference::Mode part_of(const std::string& name) {
    const auto at = std::find(parts.begin(), parts.end(), name);
    if (at == parts.end())
        throw InputError(fmt::format("--part {}: expected {}", io::printable(name), fmt::join(parts, ", ")));
    return reference::Mode(at - parts.begin());
}

// Which meshes --mesh names; empty: all.
std::vector<bool> meshes_of(const LightmapOptions& given, const Scene& scene) {
    std::vector<bool> on_map;
    for (const std::string& name : given.meshes) {
        on_map.resize(scene.meshes.size(), false);
        bool found = false;
        std::vector<std::string> names;
        for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
            names.push_back(scene.meshes[m].name);
            if (scene.meshes[m].name == name) on_map[m] = found = true;
        }
        if (!found)
            throw InputError(fmt::format("--mesh {}: no mesh has that name{}", io::printable(name),
                                         io::shown(nearest_known(name, names, "\"\""))));
    }
    return on_map;
}

bool has_second(const LightmapScene& scene, std::size_t mesh) { return mesh < scene.second.size() && !scene.second[mesh].empty(); }

std::vector<glm::vec2> second_coordinates(const LightmapScene& s, const std::vector<bool>& on_map) {
    std::vector<glm::vec2> uv;
    for (std::size_t m = 0; m < s.scene.meshes.size(); ++m) {
        const std::size_t vertices = s.scene.meshes[m].vertices.size();
        if (has_second(s, m))
            uv.insert(uv.end(), s.second[m].begin(), s.second[m].end());
        else if (on_map.empty() || on_map[m])
            throw InputError(fmt::format("{}: mesh \"{}\" has no second set of texture coordinates (TEXCOORD_1 of a glTF): --uv 0 takes the "
                                         "first set, --mesh NAME chooses meshes", s.scene.name, io::printable(s.scene.meshes[m].name)));
        else
            uv.resize(uv.size() + vertices, glm::vec2(0));
    }
    return uv;
}

std::vector<glm::vec2> first_coordinates(const Geometry& g) {
    std::vector<glm::vec2> uv;
    for (const Vertex& v : g.vertices) uv.push_back({v.u, v.v});
    return uv;
}

// Words of [reference] in the options' place, checked as such.
std::vector<std::string> settings_words(const LightmapOptions& given) {
    std::vector<std::string> sets = given.scene.sets;
    if (!given.samples.empty()) sets.push_back("reference.samples=" + given.samples);
    if (!given.until_error.empty()) sets.push_back("reference.until_error=" + given.until_error);
    return sets;
}

void check_output(const std::string& option, const std::string& file, const std::string& scene) {
    namespace fs = std::filesystem;
    if (file.empty()) return;
    std::error_code error;
    if (io::extension_of(file) != "exr") throw InputError(option + " " + io::printable(file) + ": expected a name that ends in .exr");
    if (fs::is_directory(file, error)) throw InputError(io::shown(file), "", "is a folder");
    const std::string parent = io::folder_of(file);
    if (!parent.empty() && !fs::is_directory(parent, error))
        throw InputError(io::shown(file), "", "cannot be written: there is no folder of that name");
    if (fs::equivalent(file, scene, error)) throw InputError(io::shown(file), "", "is the scene");
}

void write_map(const std::string& file, const probes::Receivers& receivers, const Buffer<glm::vec4>& values, const std::string& what,
               const LightmapOptions& given) {
    const Image4 map = probes::extend_borders(receivers, probes::scatter(receivers, values));
    io::write_exr(file, map.width, map.height, {{"color", {"R", "G", "B"}, &map.data()->x}},
                  {{"quantity", what}, {"unit", "W/m2"}, {"part", given.part}});
}

Json trace_json(const LightmapOptions& given, const std::string& layout, const probes::Lightmap& l, const probes::ReceiverIrradiance& e,
                const glm::dvec3& mean) {
    return {{"version", 1},
            {"quantity", "irradiance"},
            {"unit", "W/m2"},
            {"part", given.part},
            {"uv", layout},
            {"lightmap", {l.atlas.size.x, l.atlas.size.y}},
            {"receivers", l.receivers.count()},
            {"moved", l.moved},
            {"samples", e.samples},
            {"rounds", e.rounds},
            {"rays", e.rays},
            {"mean", {mean.x, mean.y, mean.z}},
            {"relative_error", e.relative_error},
            {"nonfinite", e.nonfinite}};
}

int trace(const LightmapOptions& given) {
    if (given.output.empty()) throw InputError("lightmap: expected -o FILE.exr, or --check FILE");
    for (const auto& [option, value] : {std::pair("--layer", &given.layer), std::pair("--map-error", &given.checked_error), std::pair("--html", &given.html)})
        if (!value->empty()) throw InputError(std::string("lightmap: ") + option + ": stands without --check");
    if (given.max_error || given.max_seam || given.max_leaks || given.scale != "1")
        throw InputError("lightmap: --scale and bounds stand without --check");
    check_output("-o", given.output, given.scene.file);
    check_output("--error", given.error_file, given.scene.file);
    if (!given.error_file.empty() && std::filesystem::weakly_canonical(given.error_file) == std::filesystem::weakly_canonical(given.output))
        throw InputError(io::shown(given.output), "", "is asked for twice");
    const LightmapScene scene = load_lightmap_scene(given);
    const std::string layout = given.uv.empty() ? "atlas" : given.uv;
    if (layout == "atlas" && !given.size.empty())
        throw InputError("--size: stands with --uv 0 or 1; --set probes.lightmap_size=N is the atlas' side");
    if (layout != "atlas" && given.size.empty()) throw InputError("--uv " + layout + ": expected --size WxH, the texels of that layout");
    const glm::ivec2 size = given.size.empty() ? glm::ivec2(0) : parse_size("--size", given.size);
    const probes::Lightmap l = lightmap_of(given, scene, layout, size, "--size " + given.size);
    const probes::ReceiverIrradiance e = trace_lightmap(given, scene, l);
    glm::dvec3 mean(0);
    for (const glm::vec4& v : e.mean) mean += glm::dvec3(v) / double(l.receivers.count());
    write_map(given.output, l.receivers, e.mean, "irradiance", given);
    if (!given.error_file.empty()) write_map(given.error_file, l.receivers, e.error, "standard error of the mean irradiance", given);
    if (given.common.json) {
        std::fputs(json_text(trace_json(given, layout, l, e, mean)).c_str(), stdout);
        return success;
    }
    print_notes(scene.scene);
    fmt::print("{} receivers on {} x {} texels ({} moved out of what they lay in); irradiance, W/m2, {}: mean {:.4g} {:.4g} {:.4g}, "
               "standard error {:.2g} % ({} paths a receiver, {:.3g} million rays)\n",
               l.receivers.count(), l.atlas.size.x, l.atlas.size.y, l.moved, given.part, mean.x, mean.y, mean.z,
               100 * e.relative_error, e.samples, double(e.rays) * 1e-6);
    if (e.nonfinite > 0) fmt::print("note: {} values are not finite\n", e.nonfinite);
    fmt::print("wrote {}\n", io::shown(given.output));
    if (!given.error_file.empty()) fmt::print("wrote {}\n", io::shown(given.error_file));
    return success;
}

}  // namespace

LightmapScene load_lightmap_scene(const LightmapOptions& given) {
    LightmapScene s;
    require_baked(given.scene.sets, {"probes", "reference"}, "plumb lightmap");
    const reference::Mode mode = part_of(given.part);
    s.scene = io::load_scene(given.scene.file, frame::method_tables(), s.second, {given.scene.strict});
    SceneOptions options = given.scene;
    options.sets = settings_words(given);
    s.settings = settings_of(s.scene, options);
    s.path = s.settings.reference;
    s.path.mode = mode;
    s.path.rays = s.settings.probes.rays;  // exact, unless a bake's are native, too
    return s;
}

std::string layout_of(const LightmapOptions& given, const LightmapScene& scene) {
    if (!given.uv.empty()) return given.uv;
    for (std::size_t m = 0; m < scene.scene.meshes.size(); ++m)
        if (has_second(scene, m)) return "1";
    return "0";
}

probes::Lightmap lightmap_of(const LightmapOptions& given, const LightmapScene& s, const std::string& layout, glm::ivec2 size,
                             const std::string& what) {
    const Geometry geometry = flatten(s.scene);
    const RunOptions options = given.common.run_options();
    if (layout == "atlas") {
        if (!given.meshes.empty()) throw InputError("--mesh: stands with --uv 0 or 1; the atlas holds all meshes");
        probes::Atlas atlas = probes::make_atlas(s.scene, geometry, probes::atlas_params(s.settings.probes));
        if (size != glm::ivec2(0) && size != atlas.size)
            throw InputError(what, "", fmt::format("is {} x {} texels; the atlas of these settings takes {} x {}", size.x, size.y,
                                                   atlas.size.x, atlas.size.y));
        return probes::place_lightmap(s.scene, std::move(atlas), s.settings.probes, options);
    }
    probes::OwnLayout own;
    own.on_map = meshes_of(given, s.scene);
    own.size = size;
    own.uv = layout == "1" ? second_coordinates(s, own.on_map) : first_coordinates(geometry);
    return probes::place_lightmap(s.scene, probes::own_layout(s.scene, geometry, own, what), s.settings.probes, options);
}

probes::ReceiverIrradiance trace_lightmap(const LightmapOptions& given, const LightmapScene& s, const probes::Lightmap& l) {
    frame::Plan plan;
    plan.stages.emplace_back();
    plan.stages[0].label = "lightmap", plan.stages[0].needed = true, plan.stages[0].expected_ms = 1;
    plan.stages[0].samples = s.path.until_error > 0 ? 0 : s.path.samples;
    ProgressBar bar(plan);
    RunOptions options = given.common.run_options();
    if (const frame::Progress call = bar.callback()) options.progress = [call](double done) { call("lightmap", done); };
    const auto path = reference::prepare(s.scene, s.path.rays);
    // A check draws other numbers than the map that is checked may have been made of: equal noise would agree.
    const std::uint32_t seed = given.checked.empty() ? s.settings.seed : ~s.settings.seed;
    return probes::receiver_irradiance(l.receivers, *path, s.path, seed, options);
}

void add_lightmap(CLI::App& program, Action& action) {
    auto given = std::make_shared<LightmapOptions>();
    CLI::App* command = program.add_subcommand("lightmap", "path trace a lightmap, with its standard error, or say whether one is right");
    command->add_option("scene", given->scene.file, "the scene: .toml, or a bare .obj, .gltf or .glb")->required()->type_name("SCENE");
    command->add_option("-o,--output", given->output, "the lightmap, .exr: irradiance in W/m2; with --check: a folder of pictures")
        ->check(some_word())->type_name("FILE");
    command->add_option("--error", given->error_file, "its standard error, .exr, W/m2")->check(some_word())->type_name("FILE");
    command->add_option("--part", given->part, "all, direct, one_bounce or indirect: by how often light was reflected before it arrives")
        ->type_name("P");
    command->add_option("--samples", given->samples, "paths a receiver: reference.samples")->check(some_word())->type_name("N");
    command->add_option("--until-error", given->until_error,
                        "in place of --samples: until the standard error is this part of the mean, 0.01 say")
        ->check(some_word())->type_name("E");
    command->add_option("--uv", given->uv, "where texels lie: atlas, as plumb bake does; 0 or 1: set of the meshes' own coordinates")
        ->check(CLI::IsMember({"atlas", "0", "1"}))->type_name("U");
    command->add_option("--size", given->size, "texels of a map with --uv 0 or 1, 1024x1024 say")->check(some_word())->type_name("WxH");
    command->add_option("--mesh", given->meshes, "with --uv 0 or 1: a mesh that is on the map, the others are not; may be repeated")
        ->allow_extra_args(false)->type_name("NAME");
    command->add_option("--set", given->scene.sets, "probes.key=value or reference.key=value in place of the scene file's; may be repeated")
        ->allow_extra_args(false)->type_name("T.K=V");
    command->add_option("--check", given->checked, "trace the truth of this map's texels, and say where the map is wrong")
        ->check(some_word())->type_name("FILE");
    command->add_option("--layer", given->layer, "of the map's file")->type_name("L");
    command->add_option("--map-error", given->checked_error, "the map's own standard error, a picture of the same size")
        ->check(some_word())->type_name("FILE");
    command->add_option("--scale", given->scale, "what the map is multiplied by to be irradiance, W/m2; pi: it holds irradiance over pi")
        ->type_name("S");
    command->add_option("--max-error", given->max_error, "bound on the relative RMS error, noise taken off")->check(number_within(0, 1e6))->type_name("E");
    command->add_option("--max-seam", given->max_seam, "bound on the worst seam, relative to the light there")->check(number_within(0, 1e6))->type_name("S");
    command->add_option("--max-leaks", given->max_leaks, "bound on the number of texels that leak")->check(CLI::Range(0, 1 << 30))->type_name("N");
    command->add_option("--html", given->html, "a page with the figures and the pictures of a check")->check(some_word())->type_name("FILE");
    add_common(*command, given->common);
    command->footer(
        "A lightmap holds irradiance in W/m2: what a diffuse surface of reflectance rho sends out is rho E / pi. Blender bakes\n"
        "\"diffuse\" without colour as E / pi, and many engines store that: --scale pi. A check takes the second set of coordinates\n"
        "where the file has one, else the first. Exit code 1 where a bound is exceeded; without a bound it is 0.\n"
        "  plumb lightmap room.toml -o truth.exr --error noise.exr --until-error 0.01\n"
        "  plumb lightmap room.glb --check baked.exr --scale pi -o report --max-error 0.05 --max-leaks 0");
    command->callback([given, &action] {
        action = [=] { return given->checked.empty() ? trace(*given) : check_user_lightmap(*given); };
    });
}

}  // namespace plumb::cli
