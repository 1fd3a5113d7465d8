// The gather along paths, 256^2 shading points of the atrium by 15 x 10 samples from a map of 512^2 texels, rotation by
// table: time by storage of the map, visibility, slots, instruction set and number of threads. What a
// packet reads lies where a picture's pixels project to.
//
//     plumb_bench --benchmark_filter=rsm.paths --benchmark_repetitions=9 --benchmark_enable_random_interleaving=true
#include <benchmark/benchmark.h>

#include <string>

#include "gi/frame/frame.h"
#include "io/scene_file.h"

namespace {

using namespace plumb;

constexpr int frame_size = 256, map_size = 512;

// The buffers that a frame's gather reads, with the map stored as `layout` says.
struct Buffers {
    Scene scene = io::load_scene(PLUMB_SOURCE_DIR "/data/scenes/atrium/atrium.toml", frame::method_tables());
    frame::Settings settings;
    frame::Frame frame;

    explicit Buffers(const raster::Layout& layout) {
        scene.frame_size = {frame_size, frame_size};
        for (Light& light : scene.lights) light.rsm_size = map_size;
        settings = frame::settings_of(scene);
        settings.layout = layout;
        settings.rsm = {};
        settings.rsm.gather = rsm::Gather::paths;
        frame = frame::execute(scene, settings, frame::plan(scene, settings), {});
    }
};

const Buffers& buffers(bool half) {
    static const Buffers halves(raster::Layout::rgba16f), floats(raster::Layout::fp32);
    return half ? halves : floats;
}

struct Case {
    bool half;
    rsm::Visibility visibility;
    int slots;
    Isa isa;
    int threads;
};

void paths(benchmark::State& state, const Case& c) {
    const Buffers& b = buffers(c.half);
    rsm::GatherParams params = b.settings.rsm;
    params.visibility = c.visibility, params.slots = c.slots;
    const rsm::Pattern pattern = rsm::pattern_of(params, map_size, 1);
    const rsm::GatherInputs in{&b.frame.gbuffer.position, &b.frame.gbuffer.normal, &b.frame.rsms[0][0], &pattern, 1};
    RunOptions options;
    options.isa = c.isa, options.threads = c.threads;
    Image4 irradiance;
    for (auto _ : state) {
        rsm::run(params, in, options, irradiance);
        benchmark::DoNotOptimize(irradiance.data());
    }
    // Reported as seconds a sample on all threads together; times `threads` it is seconds a sample of one core.
    const double samples = double(frame_size) * frame_size * params.directions * params.steps;
    state.counters["per_sample"] =
        benchmark::Counter(samples, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void add(const Case& c) {
    const std::string visibility =
        c.visibility == rsm::Visibility::none          ? "none"
        : c.visibility == rsm::Visibility::algorithm_2 ? "algorithm_2/S:" + std::to_string(c.slots)
                                                       : "algorithm_6/S:" + std::to_string(c.slots);
    const std::string name = std::string("rsm.paths/") + (c.half ? "rgba16f/" : "fp32/") + visibility + "/" +
                             isa_name(c.isa) + "/threads:" + std::to_string(c.threads);
    benchmark::RegisterBenchmark(name.c_str(), paths, c)
        ->Unit(benchmark::kMillisecond)
        ->UseRealTime()
        ->MeasureProcessCPUTime()
        ->MinTime(0.2);
}

[[maybe_unused]] const bool registered = [] {
    using rsm::Visibility;
    for (bool half : {true, false}) {
        for (Isa isa : supported_isas())
            for (int threads : {1, 2}) add({half, Visibility::algorithm_6, 5, isa, threads});
        for (int threads : {1, 2}) {
            add({half, Visibility::none, 5, best_isa(), threads});
            add({half, Visibility::algorithm_2, 5, best_isa(), threads});
            add({half, Visibility::algorithm_6, 17, best_isa(), threads});
        }
    }
    return true;
}();

}  // namespace
