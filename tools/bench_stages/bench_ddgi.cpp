// The stages of a volume of DDGI's probes, on the Cornell box: 8 x 8 x 8 probes of 256 rays; irradiance in tiles of 8 x 8, moments of
// 16 x 16; a sample at what each ray met (131,072 points), as a round asks it. By instruction set, on one and on two threads.
//
//     tools/bench ddgi
#include <benchmark/benchmark.h>

#include <string>

#include "gi/ddgi/volume.h"
#include "gi/frame/settings.h"
#include "io/scene_file.h"

namespace {

using namespace plumb;

const std::vector<StageData>& dispatches() {
    static const std::vector<StageData> all = [] {
        const Scene scene = io::load_scene(PLUMB_SOURCE_DIR "/data/scenes/cornell/cornell.toml", frame::method_tables());
        const auto lit = probes::lit_scene(scene, Rays::exact);
        glm::vec3 low, high;
        bounds(lit->geometry, low, high);
        ddgi::VolumeParams params;
        params.rounds = 3;
        ddgi::Volume volume(*lit, ddgi::grid_over(low, high, glm::ivec3(8)), params);
        volume.converge({});
        return volume.dispatches();
    }();
    return all;
}

void run_stage(benchmark::State& state, const StageBinding& binding, std::size_t dispatch, Isa isa, int threads) {
    const StageData& data = dispatches().at(dispatch);
    RunOptions options;
    options.isa = isa, options.threads = threads;
    const auto bound = binding.bind(data);
    Bundle outputs = make_outputs(binding, data);
    for (auto _ : state) {
        bound->run(options, {}, outputs);
        benchmark::DoNotOptimize(outputs.arrays[0].bytes.data());
    }
    state.counters["items"] = benchmark::Counter(double(data.size.x) * data.size.y, benchmark::Counter::kIsIterationInvariantRate,
                                                 benchmark::Counter::kIs1000);
}

[[maybe_unused]] const bool registered = [] {
    struct Stage {
        const char* name;
        const StageBinding& (*binding)();
    };
    // In the order of Volume::dispatches().
    static const Stage stages[] = {{"blend_moments", stage<ddgi::BlendKernel>},
                                   {"blend", stage<ddgi::BlendKernel>},
                                   {"border", stage<ddgi::BorderKernel>},
                                   {"sample", stage<ddgi::SampleKernel>}};
    for (std::size_t k = 0; k < std::size(stages); ++k)
        for (const Isa isa : supported_isas())
            for (const int threads : {1, 2}) {
                const std::string name = std::string("ddgi.") + stages[k].name + "/" + isa_name(isa) + "/threads:" + std::to_string(threads);
                benchmark::RegisterBenchmark(name.c_str(), [k, isa, threads](benchmark::State& state) {
                    run_stage(state, stages[k].binding(), k, isa, threads);
                })->Unit(benchmark::kMillisecond)->UseRealTime()->MinTime(0.2);
            }
    return true;
}();

}  // namespace
