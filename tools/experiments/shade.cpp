// plumb experiment indirect-shadow: the command, its table and pictures.
#include "tools/experiments/shade.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <memory>

#include "core/host_math.h"
#include "io/file.h"
#include "io/image_file.h"
#include "tools/experiments/experiments.h"
#include "tools/shared/announce.h"
#include "tools/shared/outputs.h"
#include "tools/shared/scene_command.h"

namespace plumb::cli {

namespace {

struct ShadeOptions {
    SceneOptions scene;
    Common common;
    ShadeRequest request;
    std::string folder;
};

std::string shade_csv(const ShadeResult& r) {
    std::string text = "scene,setting,spheres,ms,fit_ms,object,pixels,irradiance,change,bias,bias_uncertain,mean,rms,noise\n";
    for (const ShadeRow& row : r.rows)
        for (const auto& [object, e] : {std::pair("black", &row.black), std::pair("own", &row.whole)})
            text += fmt::format("{},\"{}\",{},{:.3f},{:.2f},{},{},{:.5g},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f}\n", r.scene, row.name, row.spheres, row.ms,
                                row.fit_ms, object, e->pixels, e->irradiance, e->change, e->bias, e->uncertain, e->mean, e->rms, e->noise);
    return text;
}

std::string shade_text(const ShadeResult& r) {
    std::string text = fmt::format("{}: {} receivers, {} places, {} x {} pixels, {} paths a pixel of each truth\n", r.scene, r.receivers, r.places,
                                   r.request.size.x, r.request.size.y, r.request.samples);
    const ShadeErrors &b = r.rows.front().black, &w = r.rows.front().whole;
    text += fmt::format("black meshes change indirect light by more than {:g} % at {} pixels, by {:.2f} % in the mean; as they are at {}, by {:.2f} %\n\n",
                        100 * r.request.least, b.pixels, 100 * b.change, w.pixels, 100 * w.change);
    text += "                              black: error of the change, % of it       as they are\n";
    text += "setting           ms    fit ms      bias         mean     rms            bias     mean     rms\n";
    for (const ShadeRow& row : r.rows)
        text += fmt::format("{:14} {:7.2f} {:7.1f} {:8.1f} +-{:4.1f} {:8.1f} {:7.1f}        {:8.1f} {:8.1f} {:7.1f}\n", row.name, row.ms, row.fit_ms,
                            100 * row.black.bias, 100 * row.black.uncertain, 100 * row.black.mean, 100 * row.black.rms, 100 * row.whole.bias,
                            100 * row.whole.mean, 100 * row.whole.rms);
    return text + fmt::format("noise of the truths' difference, a pixel: {:.1f} and {:.1f} % of the change\n", 100 * b.noise, 100 * w.noise);
}

Json shade_json(const ShadeResult& r) {
    Json json{{"scene", r.scene}, {"receivers", r.receivers}, {"places", r.places}, {"samples", r.request.samples}, {"rows", Json::array()}};
    const auto errors = [](const ShadeErrors& e) {
        return Json{{"pixels", e.pixels}, {"irradiance", e.irradiance}, {"change", e.change}, {"bias", e.bias},
                    {"bias_uncertain", e.uncertain}, {"mean", e.mean}, {"rms", e.rms}, {"noise", e.noise}};
    };
    for (const ShadeRow& row : r.rows)
        json["rows"].push_back({{"setting", row.name}, {"spheres", row.spheres}, {"ms", row.ms}, {"fit_ms", row.fit_ms},
                                {"black", errors(row.black)}, {"own", errors(row.whole)}});
    return json;
}

void write_encoded(const std::string& path, const Image4& image) {
    std::vector<std::uint8_t> rgb;
    for (const glm::vec4& t : image.texels)
        for (int c = 0; c < 3; ++c) rgb.push_back(std::uint8_t(255 * std::clamp(double(t[c]), 0.0, 1.0) + 0.5));
    io::write_png(path, image.width, image.height, rgb.data());
}

// Irradiance, white at the brightest of what is shown without shadows.
Image4 displayed(const Image4& irradiance, const Image4& like) {
    double white = 1e-30;
    for (const glm::vec4& t : like.texels) white = std::max({white, double(t.x), double(t.y), double(t.z)});
    Image4 shown(irradiance.width, irradiance.height);
    for (std::size_t i = 0; i < shown.size(); ++i)
        for (int c = 0; c < 3; ++c) shown.texels[i][c] = float(host::pow(std::clamp(double(irradiance.texels[i][c]) / white, 0.0, 1.0), 1 / 2.2));
    return shown;
}

std::string file_of(std::string name) {
    std::erase(name, ',');
    std::replace(name.begin(), name.end(), ' ', '_');
    return name;
}

int run_shade(const ShadeOptions& given) {
    ShadeRequest request = given.request;
    SceneOptions of_scene = given.scene;
    if (!of_scene.size.empty()) request.size = parse_size("--size", of_scene.size, 16);
    of_scene.size.clear();
    const Scene scene = load(of_scene);
    const frame::Settings settings = settings_of(scene, of_scene);
    std::unique_ptr<Outputs> outputs;
    if (!given.folder.empty()) outputs = std::make_unique<Outputs>(given.folder);
    // Of one core: a bake with places in the air, and paths of three truths.
    announce(fmt::format("experiment indirect-shadow: 3 truths of {} x {} pixels", request.size.x, request.size.y),
             26 + 3 * 1.6e-6 * request.size.x * request.size.y * request.samples, given.common.run_options());
    const ShadeResult r = measure_shade(scene, settings, request, given.common.run_options(),
                                        [](const std::string& line) { std::fprintf(stderr, "%s\n", line.c_str()); });
    const std::string json = json_text(shade_json(r));
    std::string text = shade_text(r);
    if (outputs) {
        outputs->write("shadow.csv", [&](const std::string& path) { io::write_text(path, shade_csv(r)); });
        outputs->write("shadow.txt", [&](const std::string& path) { io::write_text(path, text); });
        outputs->write("shadow.json", [&](const std::string& path) { io::write_text(path, json); });
        outputs->write("truth.png", [&](const std::string& path) { write_encoded(path, r.truth); });
        for (const ShadeRow& row : r.rows) {
            outputs->write(file_of(row.name) + ".error.png", [&](const std::string& path) { write_encoded(path, row.error); });
            outputs->write(file_of(row.name) + ".png", [&](const std::string& path) { write_encoded(path, displayed(row.indirect, r.rows[0].indirect)); });
        }
        outputs->commit();
        for (const std::string& file : outputs->files()) text += "wrote " + file + "\n";
    }
    std::fputs((given.common.json ? json : text).c_str(), stdout);
    return success;
}

}  // namespace

void add_indirect_shadow(CLI::App& experiment, Action& action) {
    auto given = std::make_shared<ShadeOptions>();
    CLI::App* command = experiment.add_subcommand("indirect-shadow", "what dynamic meshes hide of indirect light, and how much of it probes.indirect_shadow tells");
    command->add_option("scene", given->scene.file, "the scene: cornell_container, hall_walk")->required()->type_name("SCENE");
    command->add_option("-o,--output", given->folder, "folder for the tables and pictures")->check(some_word())->type_name("DIR");
    command->add_option("--samples", given->request.samples, "paths a pixel of each truth; 2048 otherwise")->check(CLI::Range(32, 1 << 20).description(""))->type_name("N");
    command->add_option("--repeats", given->request.repeats, "whose median is the time; 5 otherwise")->check(CLI::Range(1, 1000).description(""))->type_name("N");
    add_size_option(*command, given->scene);
    add_preset_option(*command, given->scene.preset);
    command->add_option("--set", given->scene.sets, "table.key=value in place of the scene file's; may be repeated")->allow_extra_args(false)->type_name("T.K=V");
    add_common(*command, given->common);
    command->footer(
        "Indirect light of static surfaces is path traced without the dynamic meshes, with them in black, and as they are. Where it changes by\n"
        "more than 1 % and twice its noise, the change that the frame shows (by method probes, with and without the meshes) is held against it.");
    command->callback([given, &action] { action = [=] { return run_shade(*given); }; });
}

}  // namespace plumb::cli
