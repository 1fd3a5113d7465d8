// Runs the twin of every stage of a frame on a device and judges what it wrote: the table of data/parity/.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <exception>
#include <iostream>
#include <map>

#include "core/error.h"
#include "gi/frame/probe_bake.h"
#include "gi/parity/stages.h"
#include "gi/parity/verdict.h"
#include "io/scene_file.h"
#include "tools/shared/announce.h"
#include "tools/vulkan/profile.h"
#include "tools/vulkan/runner.h"

namespace plumb {
namespace {

struct Options {
    std::string device = "llvmpipe";
    std::vector<std::string> scenes, profiles{"device", "ideal"}, gathers;
    std::vector<std::string> sizes{"1024x1024", "1000x562"};
    int samples = 0;  // of rsm.disc; 0: as the scene says
    bool validate = false;
};

// All dispatches of one stage, in all scenes and sizes.
struct Row {
    int dispatches = 0;
    std::int64_t pixels = 0;
    std::array<std::int64_t, parity::verdicts> count{};
};
using Table = std::map<std::pair<std::string, std::string>, Row>;  // by profile and stage

glm::ivec2 parse_size(const std::string& text) {
    glm::ivec2 size(0);
    char x = 0, rest = 0;
    if (std::sscanf(text.c_str(), "%d%c%d%c", &size.x, &x, &size.y, &rest) != 3 || x != 'x')
        throw InputError("--sizes: \"" + text + "\": expected width and height as 1024x1024");
    return size;
}

std::vector<parity::Dumped> dumped(const Bundle& outputs) {
    std::vector<parity::Dumped> all;
    for (const Array& a : outputs.arrays) all.push_back({a.name, a, Format::rgba32f, 15});
    return all;
}

void add_row(const parity::StageVerdict& v, Row& row) {
    ++row.dispatches;
    row.pixels += v.pixels;
    for (std::size_t i = 0; i < v.count.size(); ++i) row.count[i] += v.count[i];
}

void judge_frame(const vulkan::Device& device, const std::string& file, glm::ivec2 size, const std::string& gather,
                 const Options& options, Table& table) {
    Scene scene = io::load_scene(file, frame::method_tables());
    scene.frame_size = size;
    frame::Settings settings = frame::settings_of(scene);
    if (!gather.empty()) {
        std::vector<Field> fields = frame::table_fields(settings, "rsm", "--gathers");
        set_field(find_field(fields, "gather", "--gathers"), gather, "--gathers");
    }
    if (options.samples > 0) settings.rsm.samples = options.samples;
    frame::add_bake(scene, settings);
    const frame::Plan plan = frame::plan(scene, settings);
    const frame::Frame frame = frame::execute(scene, settings, plan, {});
    for (const StageData& data : parity::frame_data(scene, settings, plan, frame)) {
        const StageBinding& binding = parity::find_binding(data.stage, file);
        const vulkan::TwinResult result = vulkan::run_twin(device, binding, data);
        for (const std::string& name : options.profiles) {
            parity::JudgeOptions judging;
            judging.profile = name == "device" ? vulkan::profile_of(device) : find_profile(name, "--profiles");
            const parity::StageVerdict v = parity::judge(binding, data, dumped(result.outputs), judging);
            add_row(v, table[{judging.profile.name, data.stage}]);
            if (v.verdict == parity::Verdict::equal) continue;
            fmt::print("{} {}x{} {}, profile {}: {} equal, {} within bound, {} ambiguous, {} wrong\n", scene.name,
                       size.x, size.y, data.id, judging.profile.name, v.count[0], v.count[1], v.count[2], v.count[3]);
            if (v.worst.empty()) continue;
            const parity::WorstPixel& w = v.worst[0];
            fmt::print("    worst: {} at {},{}: {}[{}] expected {:.9g} got {:.9g} bound {:.3g}\n",
                       parity::verdict_name(w.verdict), w.pixel.x, w.pixel.y, w.output, w.channel, w.expected, w.got,
                       w.bound);
        }
        std::cout.flush();
    }
}

// Largest shares are printed in full: 100 % is every pixel.
std::string share(std::int64_t n, std::int64_t pixels) {
    if (pixels == 0) return "-";
    return n == 0 ? "0" : n == pixels ? "100 %" : fmt::format("{:.4f} %", 100.0 * double(n) / double(pixels));
}

void print(const vulkan::Device& device, const Table& table) {
    fmt::print("\n{}\n\n| profile | stage | dispatches | pixels | equal | within bound | ambiguous | wrong |\n"
               "|---|---|---|---|---|---|---|---|\n", device.name());
    for (const auto& [key, row] : table)
        fmt::print("| {} | {} | {} | {} | {} | {} | {} | {} |\n", key.first, key.second, row.dispatches, row.pixels,
                   share(row.count[0], row.pixels), share(row.count[1], row.pixels), share(row.count[2], row.pixels),
                   share(row.count[3], row.pixels));
}

}  // namespace
}  // namespace plumb

int main(int argc, char** argv) {
    using namespace plumb;
    Options options;
    CLI::App app("Runs the twin of every stage of frames on a device and judges what it wrote", "plumb_parity");
    app.add_option("--device", options.device, "a part of the device's name (llvmpipe)");
    app.add_option("scenes", options.scenes, "scene files")->required();
    app.add_option("--sizes", options.sizes, "of the frames (1024x1024,1000x562)")->delimiter(',');
    app.add_option("--profiles", options.profiles, "device: the one that fits its driver (device,ideal)")->delimiter(',');
    app.add_option("--gathers", options.gathers, "disc, all (as the scene says)")->delimiter(',');
    app.add_option("--samples", options.samples, "of rsm.disc (as the scene says)");
    app.add_flag("--validate", options.validate, "with the validation layers on; what they say is a failure");
    CLI11_PARSE(app, argc, argv);
    try {
        const vulkan::Device device({.name = options.device, .validate = options.validate});
        if (options.gathers.empty()) options.gathers = {""};
        // Of one core on a software device, about: 37 s a million pixels (llvmpipe).
        double pixels = 0;
        for (const std::string& size : options.sizes) pixels += double(parse_size(size).x) * parse_size(size).y;
        const std::size_t frames = options.scenes.size() * options.gathers.size();
        cli::announce(fmt::format("parity: {} frames of {} sizes under {} profiles", frames, options.sizes.size(), options.profiles.size()),
                      37e-6 * pixels * double(frames * options.profiles.size()), {});
        Table table;
        for (const std::string& scene : options.scenes)
            for (const std::string& size : options.sizes)
                for (const std::string& gather : options.gathers)
                    judge_frame(device, scene, parse_size(size), gather, options, table);
        print(device, table);
        bool good = true;
        for (const auto& [key, row] : table) good &= row.count[int(parity::Verdict::wrong)] == 0;
        if (options.validate && !device.validated())
            throw vulkan::Error("--validate: VK_LAYER_KHRONOS_validation is not installed");
        for (const std::string& complaint : device.complaints()) {
            fmt::print("validation: {}\n", complaint);
            good = false;
        }
        return good ? 0 : 1;
    } catch (const InputError& error) {
        std::cerr << "plumb_parity: " << error.what() << "\n";
        return 2;
    } catch (const std::exception& error) {
        std::cerr << "plumb_parity: " << error.what() << "\n";
        return 1;
    }
}
