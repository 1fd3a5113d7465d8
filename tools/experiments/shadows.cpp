// plumb experiment shadows: the command, its table and pictures.
#include "tools/experiments/shadows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <memory>

#include "io/file.h"
#include "io/image_file.h"
#include "tools/experiments/experiments.h"
#include "tools/shared/announce.h"
#include "tools/shared/outputs.h"
#include "tools/shared/reports.h"
#include "tools/shared/scene_command.h"
#include "tools/shared/table.h"

namespace plumb::cli {

namespace {

struct ShadowsOptions {
    Common common;
    std::vector<std::string> scenes, sets, ways;
    std::vector<int> sizes = {256, 512, 1024}, maps = {0};
    std::string folder, preset;
};

std::string percent(double share) { return fmt::format("{:.3f}", 100 * share); }

std::string shadows_text(const std::vector<ShadowRow>& rows) {
    std::vector<std::vector<std::string>> cells;
    for (const ShadowRow& r : rows)
        cells.push_back({r.scene, std::to_string(r.size), std::to_string(r.map), r.way, std::to_string(r.errors.lit), std::to_string(r.errors.dark),
                         std::to_string(r.errors.acne), std::to_string(r.errors.leak), std::to_string(r.errors.edge), percent(r.errors.beside),
                         percent(r.errors.light), fmt::format("{:.1f}", r.ms)});
    const Align right = Align::right;
    return format_table({{"scene"}, {"pixels", right}, {"map", right}, {"shadow", Align::left}, {"lit", right}, {"dark", right}, {"acne", right},
                         {"leak", right}, {"edge", right}, {"of them, light %", right}, {"all light %", right}, {"ms", right}},
                        cells);
}

std::string shadows_csv(const std::vector<ShadowRow>& rows) {
    std::string text = "scene,pixels,map,shadow,lit,dark,acne,leak,edge,beside,light,ms\n";
    for (const ShadowRow& r : rows)
        text += fmt::format("{},{},{},\"{}\",{},{},{},{},{},{:.6g},{:.6g},{:.3f}\n", r.scene, r.size, r.map, r.way, r.errors.lit, r.errors.dark,
                            r.errors.acne, r.errors.leak, r.errors.edge, r.errors.beside, r.errors.light, r.ms);
    return text;
}

Json shadows_json(const std::vector<ShadowRow>& rows) {
    Json list = Json::array();
    for (const ShadowRow& r : rows)
        list.push_back({{"scene", r.scene}, {"pixels", r.size}, {"map", r.map}, {"shadow", r.way}, {"lit", r.errors.lit}, {"dark", r.errors.dark},
                        {"acne", r.errors.acne}, {"leak", r.errors.leak}, {"edge", r.errors.edge}, {"beside", r.errors.beside},
                        {"light", r.errors.light}, {"ms", r.ms}});
    return {{"rows", list}};
}

void write_rgb(const std::string& path, const Image4& image) {
    std::vector<std::uint8_t> rgb;
    for (const glm::vec4& t : image.texels)
        for (int c = 0; c < 3; ++c) rgb.push_back(std::uint8_t(255 * std::clamp(double(t[c]), 0.0, 1.0) + 0.5));
    io::write_png(path, image.width, image.height, rgb.data());
}

std::vector<ShadowWay> ways_of(const ShadowsOptions& given) {
    std::vector<ShadowWay> all = shadow_ways(), chosen;
    if (given.ways.empty()) return all;
    for (const std::string& name : given.ways) {
        const auto at = std::find_if(all.begin(), all.end(), [&](const ShadowWay& w) { return w.name == name; });
        if (at == all.end()) {
            std::string names;
            for (const ShadowWay& w : all) names += (names.empty() ? "\"" : ", \"") + w.name + "\"";
            throw InputError(fmt::format("--way \"{}\": expected one of {}", name, names));
        }
        chosen.push_back(*at);
    }
    return chosen;
}

int run_shadows(const ShadowsOptions& given) {
    const std::vector<ShadowWay> ways = ways_of(given);
    std::unique_ptr<Outputs> outputs;
    if (!given.folder.empty()) outputs = std::make_unique<Outputs>(given.folder);
    double pixels = 0;
    for (const int size : given.sizes) pixels += double(size) * size;
    // Of one core: 2 us a ray of a pixel and what is asked about edges.
    announce(fmt::format("experiment shadows: {} scene{}", given.scenes.size(), given.scenes.size() == 1 ? "" : "s"),
             double(given.scenes.size() * given.maps.size()) * pixels * (2e-6 + 0.4e-6 * double(ways.size())), given.common.run_options());
    std::vector<ShadowRow> rows;
    for (const std::string& file : given.scenes) {
        SceneOptions words;
        words.file = file, words.preset = given.preset, words.sets = given.sets;
        Scene scene = load(words);
        scene.name = io::stem_of(file);
        for (const int size : given.sizes)
            for (const int map : given.maps) {
                auto tell = [&](const std::string& line) { std::fprintf(stderr, "%s, %d: %s\n", scene.name.c_str(), size, line.c_str()); };
                std::vector<ShadowRow> some = measure_shadows(scene, words, ways, size, map, given.common.run_options(), tell);
                for (ShadowRow& row : some) {
                    if (outputs) {
                        std::string name = fmt::format("{}_{}_{}_{}.png", row.scene, row.size, row.map, row.way);
                        std::erase(name, ','), std::replace(name.begin(), name.end(), ' ', '_');
                        outputs->write(name, [&](const std::string& path) { write_rgb(path, row.where); });
                    }
                    row.where = {};
                    rows.push_back(std::move(row));
                }
            }
    }
    const std::string json = json_text(shadows_json(rows));
    std::string text = shadows_text(rows);
    if (outputs) {
        outputs->write("shadows.csv", [&](const std::string& path) { io::write_text(path, shadows_csv(rows)); });
        outputs->write("shadows.txt", [&](const std::string& path) { io::write_text(path, text); });
        outputs->write("shadows.json", [&](const std::string& path) { io::write_text(path, json); });
        outputs->commit();
        for (const std::string& file : outputs->files()) text += "wrote " + file + "\n";
    }
    std::fputs((given.common.json ? json : text).c_str(), stdout);
    return success;
}

}  // namespace

void add_shadows(CLI::App& experiment, Action& action) {
    auto given = std::make_shared<ShadowsOptions>();
    CLI::App* command = experiment.add_subcommand("shadows", "shadows by every test and filter against a ray to the light at each pixel");
    command->add_option("scenes", given->scenes, "scenes: .toml, or bare .obj, .gltf or .glb")->required()->type_name("SCENE");
    command->add_option("-o,--output", given->folder, "folder for shadows.txt, shadows.csv, shadows.json and a picture a row")->check(some_word())->type_name("DIR");
    command->add_option("--sizes", given->sizes, "sides of the frames, pixels; 256,512,1024 otherwise")
        ->delimiter(',')->check(CLI::Range(16, 8192).description(""))->type_name("N,N");
    command->add_option("--maps", given->maps, "sides of the lights' maps, texels; 0, and otherwise: the scene's own")
        ->delimiter(',')->check(CLI::Range(0, 16384).description(""))->type_name("N,N");
    command->add_option("--way", given->ways, "of the table's ways this one; may be repeated; all otherwise")->allow_extra_args(false)->type_name("NAME");
    add_preset_option(*command, given->preset);
    command->add_option("--set", given->sets, "table.key=value in place of the scene files'; may be repeated")->allow_extra_args(false)->type_name("T.K=V");
    add_common(*command, given->common);
    command->footer(
        "acne: a ray reaches the light, and more than 1/16 of it is missing; leak: none does, and more than 1/16 arrives; edge: either, where\n"
        "within the texels that the way reads a point of the surface's plane is lit and another is not. light: irradiance that is missing or\n"
        "too much, of all that arrives: of acne and leak, and of all pixels. Pictures: red acne, blue leak, green edge.");
    command->callback([given, &action] { action = [=] { return run_shadows(*given); }; });
}

}  // namespace plumb::cli
