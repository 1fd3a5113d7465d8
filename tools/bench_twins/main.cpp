// Every stage against its twin on a device: the same inputs, in turns, wall clock. What is timed is one dispatch or draw
// with all buffers in place, from submission to completion; ours is one run of the stage into memory that is kept. CPU:
// of all threads together, which other programs on the machine hardly change.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstring>
#include <exception>
#include <functional>
#include <iostream>
#include <memory>

#include "core/error.h"
#include "core/parallel.h"
#include "gi/frame/frame_graph.h"
#include "gi/frame/kept.h"
#include "gi/frame/probe_bake.h"
#include "gi/parity/stages.h"
#include "gi/rsm/gather.h"
#include "io/scene_file.h"
#include "raster/light_view.h"
#include "raster/workspace.h"
#include "tools/bench_raster/measure.h"
#include "tools/bench_stages/update_work.h"
#include "tools/shared/options.h"
#include "tools/vulkan/runner.h"

namespace plumb::bench {
namespace {

struct Options {
    std::string device = "llvmpipe";
    std::vector<std::string> scenes{"data/scenes/cornell/cornell.toml", "data/scenes/atrium/atrium.toml"};
    std::vector<std::string> stages;  // empty: all
    std::vector<std::string> sets;    // table.key=value, as of `plumb render`
    std::string method;               // empty: as the scene says
    int width = 1024, height = 1024, runs = 7;
    int samples = 0, rsm_size = 0;    // 0: as the scene says
    bool half_maps = false;           // lights' maps in RGBA16F, ours and theirs
    bool update = false;              // of irradiance probes, instead of scenes
    RunOptions run;
};

// What differs between ours and theirs, in 32-bit words.
std::size_t differing(const void* ours, const Array& theirs) {
    const auto* a = static_cast<const unsigned char*>(ours);
    std::size_t n = 0;
    for (std::size_t i = 0; i < theirs.bytes.size(); i += 4) n += std::memcmp(a + i, theirs.bytes.data() + i, 4) != 0;
    return n;
}

void measure(const vulkan::Device& device, const std::string& file, const Options& options) {
    Scene scene = io::load_scene(file, frame::method_tables());
    scene.frame_size = {options.width, options.height};
    cli::SceneOptions words;
    words.sets = options.sets;
    words.method = options.method;
    frame::Settings settings = cli::settings_of(scene, words);
    // Maps alone are halves: what a stage writes is compared with a twin that writes floats.
    settings.layout = raster::Layout::fp32;
    if (options.half_maps) {
        raster::Layout& to = settings.layout;
        to.name = "custom";
        to.rsm_position = to.rsm_normal = to.rsm_flux = Format::rgba16f;
        to.rsm_depth = Format::r16f;
    }
    if (options.samples > 0) settings.rsm.samples = options.samples;
    for (Light& light : scene.lights)
        if (options.rsm_size > 0) light.rsm_size = options.rsm_size;
    frame::add_bake(scene, settings);
    const frame::Plan plan = frame::plan(scene, settings);
    frame::KeptStages kept;
    const frame::Frame& frame = frame::execute(scene, settings, plan, options.run, kept);
    // Each stage as a frame runs it, in memory that is kept.
    frame::FrameGraph graph(scene, settings, plan, kept.memory());
    graph.context().keeps = true;
    vulkan::RunTwin how;
    if (options.half_maps) how.maps = Format::rgba16f;
    std::string last;
    double ours_ms = 0, theirs_ms = 0, ours_cpu = 0, theirs_cpu = 0;  // of all stages of gi/isr
    for (const StageData& data : parity::frame_data(scene, settings, plan, frame)) {
        // Of the dispatches of one stage the first stands for all; those of image-space radiosity are a chain.
        const bool chained = settings.method == frame::Method::isr && data.stage.starts_with("isr.");
        if (data.stage == last && !chained) continue;
        last = data.stage;
        const auto& wanted = options.stages;
        if (!wanted.empty() && std::find(wanted.begin(), wanted.end(), data.stage) == wanted.end()) continue;
        const StageBinding& binding = parity::find_binding(data.stage, "bench twins");
        vulkan::PreparedTwin twin(device, binding, data, how);
        // A dispatch may have a face behind the row's label. Of a stage without a light and with one, each has its own row.
        auto planned = std::find_if(plan.stages.begin(), plan.stages.end(),
                                    [&](const frame::PlannedStage& s) { return data.label == s.label; });
        if (planned == plan.stages.end())
            planned = std::find_if(plan.stages.begin(), plan.stages.end(),
                                   [&](const frame::PlannedStage& s) { return data.label.starts_with(s.label + " "); });
        const frame::PlannedNode& node = graph.node(*planned);
        auto run_ours = [&] {
            return clock_ms([&] {
                graph::NodeRun run;
                node.run(options.run, run);
            });
        };
        const std::vector<Times> times = interleave(options.runs, {run_ours, [&] { return twin.submit(); }});
        std::string note = "the same bits";
        if (!binding.raster) {
            const Bundle theirs = twin.read().outputs, ours = node.outputs();
            const std::size_t n = differing(at(ours, theirs.arrays[0].name).bytes.data(), theirs.arrays[0]);
            if (n > 0) note = fmt::format("{} words differ", n);
        } else {
            note = "drawn";
        }
        fmt::print("| {} | {} | {} x {} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {} |\n", scene.name,
                   data.label, data.size.x, data.size.y, times[0].median(), times[1].median(),
                   times[1].median() / times[0].median(), times[0].cpu_median(), times[1].cpu_median(),
                   times[1].cpu_median() / times[0].cpu_median(), note);
        std::cout.flush();
        if (!chained) continue;
        ours_ms += times[0].median(), theirs_ms += times[1].median();
        ours_cpu += times[0].cpu_median(), theirs_cpu += times[1].cpu_median();
    }
    if (ours_ms > 0)
        fmt::print("| {} | all of isr.*, summed | {} x {} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | |\n", scene.name,
                   options.width, options.height, ours_ms, theirs_ms, theirs_ms / ours_ms, ours_cpu, theirs_cpu,
                   theirs_cpu / ours_cpu);
}

// A dispatch, bound, with memory for its output.
struct Bound {
    const StageBinding& binding;
    StageData data;
    std::unique_ptr<BoundStage> stage = binding.bind(data);
    Bundle outputs = make_outputs(binding, data);

    explicit Bound(StageData of) : binding(parity::find_binding(of.stage, "bench twins")), data(std::move(of)) {}
    void run(const Options& options) { stage->run(options.run, {}, outputs); }
    // Each input read once, each output written once.
    double bytes() const {
        double sum = 0;
        for (const Bundle* bundle : {&data.inputs, &outputs})
            for (const Array& a : bundle->arrays) sum += double(a.bytes.size());
        return sum;
    }
};

// The update of irradiance probes, whose dispatches no frame of a scene file has in these sizes.
void measure_update(const vulkan::Device& device, const UpdateSize& size, const Options& options) {
    const UpdateWork work(size);
    for (const StageData& data : work.all()) {
        Bound ours(data);
        vulkan::PreparedTwin twin(device, ours.binding, data, {});
        const auto run_ours = [&] { return clock_ms([&] { ours.run(options); }); };
        const std::vector<Times> times = interleave(options.runs, {run_ours, [&] { return twin.submit(); }});
        const Bundle theirs = twin.read().outputs;
        const std::size_t n = differing(std::as_const(ours.outputs.arrays[0].bytes).data(), theirs.arrays[0]);
        fmt::print("| {} receivers | {} | {} x {} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {} |\n", size.receivers,
                   data.label, data.size.x, data.size.y, times[0].median(), times[1].median(),
                   times[1].median() / times[0].median(), times[0].cpu_median(), times[1].cpu_median(),
                   times[1].cpu_median() / times[0].cpu_median(), n > 0 ? fmt::format("{} words differ", n) : "the same bits");
        std::cout.flush();
    }
}

// The same without a device, in turns with a copy that moves as much as the three stages which memory bounds: half of it is read,
// half is written.
void measure_against_copy(const UpdateSize& size, const Options& options) {
    constexpr int piece = 1 << 16, first_of_three = 2, runs_a_run = 15;
    const UpdateWork work(size);
    std::vector<std::unique_ptr<Bound>> stages;
    for (StageData& data : work.all()) stages.push_back(std::make_unique<Bound>(std::move(data)));
    double bytes_of_three = 0, bytes = 0;
    for (std::size_t i = 0; i < stages.size(); ++i) (i < first_of_three ? bytes : bytes_of_three) += stages[i]->bytes();
    bytes += bytes_of_three;
    const int pieces = int(bytes_of_three / 2 / piece);
    const Buffer<unsigned char> from(std::size_t(pieces) * piece, 1);
    Buffer<unsigned char> to(from.size(), 2);
    const auto run_from = [&](std::size_t first) {
        return [&, first] { return clock_ms([&] { for (std::size_t i = first; i < stages.size(); ++i) stages[i]->run(options); }); };
    };
    std::vector<std::function<double()>> sides = {[&] {
        return clock_ms([&] {
            parallel_bands(pieces, 4, options.run, [&](int first, int last) {
                std::memcpy(&to[std::size_t(first) * piece], &from[std::size_t(first) * piece], std::size_t(last - first) * piece);
            });
        });
    }, run_from(0), run_from(first_of_three)};
    for (const auto& one : stages) sides.push_back([&options, &one] { return clock_ms([&] { one->run(options); }); });
    const std::vector<Times> times = interleave(options.runs * runs_a_run, sides);
    const double of_copy = 2.0 * double(from.size()) / times[0].median();
    const auto row = [&](const std::string& what, const Times& time, double moved) {
        fmt::print("| {}, {} | {} | {:.3f} | {:.3f} | {:.1f} | {:.1f} | {:.0f} % |\n", size.receivers, size.probes, what, time.median(),
                   time.least(), moved * 1e-6, moved / time.median() * 1e-6, 100 * moved / time.median() / of_copy);
    };
    row("copy", times[0], 2.0 * double(from.size()));
    for (std::size_t i = 0; i < stages.size(); ++i) row(stages[i]->data.stage, times[3 + i], stages[i]->bytes());
    row("the last three", times[2], bytes_of_three), row("all five", times[1], bytes);
    std::cout.flush();
}

}  // namespace
}  // namespace plumb::bench

int main(int argc, char** argv) {
    using namespace plumb;
    bench::Options options;
    std::string isa = "auto";
    CLI::App app("Times every stage of a frame against its twin on a device, with the same inputs and in turns",
                 "tools/bench twins");
    app.add_option("--against-device", options.device, "a part of the device's name (llvmpipe)");
    app.add_option("--scenes", options.scenes, "scene files (cornell and atrium)")->delimiter(',');
    app.add_option("--stages", options.stages, "names of `plumb stages` (all)")->delimiter(',');
    app.add_option("--set", options.sets, "table.key=value, as of `plumb render`; may be repeated");
    app.add_option("--method", options.method, "as of `plumb render` (as the scene says)");
    app.add_flag("--half-maps", options.half_maps, "lights' maps in RGBA16F on both sides, and not in fp32");
    app.add_flag("--update", options.update, "the update of irradiance probes, of two sizes, and no scene; and in turns with a copy");
    app.add_option("--samples", options.samples, "of rsm.disc (as the scene says)")->check(CLI::Range(1, 65536));
    app.add_option("--rsm-size", options.rsm_size, "texels a side of every map (as the scene says)")
        ->check(CLI::Range(1, 16384));
    app.add_option("--width", options.width, "pixels (1024)")->check(CLI::Range(1, 16384));
    app.add_option("--height", options.height, "pixels (1024)")->check(CLI::Range(1, 16384));
    app.add_option("--runs", options.runs, "runs of each side, in turns (7)")->check(CLI::Range(1, 1000));
    app.add_option("--threads", options.run.threads, "of ours; 0: all processors (0)")->check(CLI::Range(0, 1024));
    app.add_option("--isa", isa, "auto, scalar, sse, avx2 or avx512 (auto)");
    CLI11_PARSE(app, argc, argv);
    try {
        options.run.isa = parse_isa(isa);
        const vulkan::Device device({.name = options.device});
        fmt::print("{}; {} threads of ours\n\n", device.name(), thread_count(options.run.threads));
        fmt::print("| scene | stage | pixels | ours, ms | twin, ms | twin / ours | ours, CPU ms | twin, CPU ms "
                   "| twin / ours | results |\n|---|---|---|---|---|---|---|---|---|---|\n");
        if (options.update) {
            for (const bench::UpdateSize& size : bench::update_sizes) bench::measure_update(device, size, options);
            fmt::print("\n| receivers, probes | stage | ms | least | moves, MB | GB/s | of the copy's |\n|---|---|---|---|---|---|---|\n");
            for (const bench::UpdateSize& size : bench::update_sizes) bench::measure_against_copy(size, options);
        } else
            for (const std::string& scene : options.scenes) bench::measure(device, scene, options);
        return 0;
    } catch (const InputError& error) {
        std::cerr << "bench twins: " << error.what() << "\n";
        return 2;
    } catch (const std::exception& error) {
        std::cerr << "bench twins: " << error.what() << "\n";
        return 1;
    }
}
