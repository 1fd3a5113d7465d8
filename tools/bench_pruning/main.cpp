// What leaving out saves: each scene's frame with and without pruning, in turns, and whether their pictures are the same.
#include <fmt/core.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstring>
#include <exception>
#include <functional>
#include <iostream>

#include "core/error.h"
#include "core/parallel.h"
#include "gi/frame/frame.h"
#include "io/scene_file.h"
#include "tools/bench_raster/measure.h"

namespace plumb::bench {
namespace {

struct Options {
    std::vector<std::string> scenes;  // empty: all
    int width = 512, height = 512, runs = 5;
    RunOptions run;
};

// A scene as its file has it, or with a change that people make.
struct Entry {
    std::string name, file;
    std::function<void(Scene&, frame::Settings&)> change = [](Scene&, frame::Settings&) {};
};

void direct_light(Scene&, frame::Settings& settings) { settings.method = frame::Method::direct; }
void first_light_off(Scene& scene, frame::Settings&) { scene.lights.at(0).on = false; }
void bulb(Scene& scene, frame::Settings&) {
    Light& light = scene.lights.at(0);
    light.type = LightType::point;
    light.position = glm::vec3(scene.camera.position);
}
void look_away(Scene& scene, frame::Settings&) {
    scene.camera.look_at = scene.camera.position * 2.0 - scene.camera.look_at;
}

std::vector<Entry> entries() {
    const std::string at = "data/scenes/";
    return {{"cornell", at + "cornell/cornell.toml"},
            {"cornell, direct light", at + "cornell/cornell.toml", direct_light},
            {"cornell, its light off", at + "cornell/cornell.toml", first_light_off},
            {"box", at + "box/box.toml"},
            {"shapes", at + "shapes/shapes.toml"},
            {"rooms", at + "rooms/rooms.toml"},
            {"rooms, a bulb at the camera", at + "rooms/rooms.toml", bulb},
            {"hall", at + "hall/hall.toml"},
            {"city", at + "city/city.toml"},
            {"city, the first light off", at + "city/city.toml", first_light_off},
            {"atrium", at + "atrium/atrium.toml"},
            {"atrium, direct light", at + "atrium/atrium.toml", direct_light},
            {"atrium, from behind", at + "atrium/atrium.toml", look_away}};
}

bool same(const Image4& a, const Image4& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(glm::vec4)) == 0;
}

// What was left out, "rsm (sun)" or "part of shadow (sun)", and by which rules.
std::string left_out(const std::vector<frame::StageRun>& stages) {
    std::vector<std::string> names, rules;
    auto note = [&](const std::string& rule) {
        if (std::find(rules.begin(), rules.end(), rule) == rules.end()) rules.push_back(rule);
    };
    for (const frame::StageRun& s : stages) {
        if (!s.needed) names.push_back(s.label), note(s.rule);
        if (s.needed && !s.parts.empty()) names.push_back("part of " + s.label);
        for (const frame::LeftOut& part : s.parts) note(part.rule);
    }
    if (names.empty()) return "nothing |";
    return fmt::format("{} | {}", fmt::join(names, ", "), fmt::join(rules, ", "));
}

bool measure(const Entry& entry, const Options& options) {
    Scene scene = io::load_scene(entry.file, frame::method_tables());
    scene.frame_size = {options.width, options.height};
    frame::Settings settings = frame::settings_of(scene);
    entry.change(scene, settings);
    frame::Settings all = settings;
    all.pruning = false;
    const frame::Plan pruned_plan = frame::plan(scene, settings), whole_plan = frame::plan(scene, all);
    frame::Frame pruned, whole;
    const std::vector<Times> times = interleave(
        options.runs,
        {[&] { return clock_ms([&] { pruned = frame::execute(scene, settings, pruned_plan, options.run); }); },
         [&] { return clock_ms([&] { whole = frame::execute(scene, all, whole_plan, options.run); }); }});
    const bool equal = same(pruned.radiance, whole.radiance) && same(pruned.display, whole.display) &&
                       same(pruned.direct, whole.direct) && same(pruned.indirect, whole.indirect);
    const double with = times[0].median(), without = times[1].median();
    fmt::print("| {} | {:.1f} | {:.1f} | {:.1f} | {:.2f} | {} | {} |\n", entry.name, without, with, without - with,
               without / with, left_out(pruned.stages), equal ? "the same bits" : "DIFFERENT");
    std::fflush(stdout);
    return equal;
}

}  // namespace
}  // namespace plumb::bench

int main(int argc, char** argv) {
    using namespace plumb;
    bench::Options options;
    std::string isa = "auto";
    CLI::App app{"Frame times with and without pruning, in turns: medians, and what was left out."};
    app.add_option("--scenes", options.scenes, "names of the table's rows, between semicolons (all)")->delimiter(';');
    app.add_option("--width", options.width, "pixels (512)")->check(CLI::Range(1, 16384));
    app.add_option("--height", options.height, "pixels (512)")->check(CLI::Range(1, 16384));
    app.add_option("--runs", options.runs, "runs of each side, in turns (5)")->check(CLI::Range(1, 1000));
    app.add_option("--threads", options.run.threads, "0: all processors (0)")->check(CLI::Range(0, 1024));
    app.add_option("--isa", isa, "auto, scalar, sse, avx2 or avx512 (auto)");
    CLI11_PARSE(app, argc, argv);
    try {
        options.run.isa = parse_isa(isa);
        fmt::print("{} threads, {}, {} x {} pixels, medians of {} runs in turns\n\n", thread_count(options.run.threads),
                   isa_name(options.run.isa), options.width, options.height, options.runs);
        fmt::print("| scene | without pruning, ms | with, ms | saved, ms | ratio | left out | rules | pictures |\n"
                   "|---|---|---|---|---|---|---|---|\n");
        bool equal = true;
        for (const bench::Entry& entry : bench::entries())
            if (options.scenes.empty() ||
                std::find(options.scenes.begin(), options.scenes.end(), entry.name) != options.scenes.end())
                equal = bench::measure(entry, options) && equal;
        return equal ? 0 : 1;
    } catch (const InputError& error) {
        std::cerr << "bench pruning: " << error.what() << "\n";
        return 2;
    } catch (const std::exception& error) {
        std::cerr << "bench pruning: " << error.what() << "\n";
        return 1;
    }
}
