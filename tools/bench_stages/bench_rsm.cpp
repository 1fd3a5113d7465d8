// RSM gather, 256^2 shading points by 150 samples from a 512^2 map, rotation by table, no visibility: time by storage,
// instruction set and number of threads.
//
//     plumb_bench --benchmark_filter=rsm.disc --benchmark_repetitions=9 --benchmark_enable_random_interleaving=true
#include <benchmark/benchmark.h>

#include <string>

#include "core/formats.h"
#include "core/hash.h"
#include "core/host_math.h"
#include "gi/rsm/gather.h"

namespace {

using namespace plumb;

constexpr int frame = 256, map_size = 512, samples = 150;

// A floor of 2 m x 2 m below a ceiling, both with bumps: the light shines upwards through the floor's points, so that a
// point projects to the texel above it and its neighbourhood on the map is its neighbourhood in space.
struct Scene {
    Image4 position{frame, frame}, normal{frame, frame};
    raster::Rsm rsm;

    Scene() {
        for (int y = 0; y < frame; ++y)
            for (int x = 0; x < frame; ++x) {
                const double u = (x + 0.5) / frame * 2 - 1, v = (y + 0.5) / frame * 2 - 1;
                position(x, y) = glm::vec4(u, 0.05 * host::sin(7 * u) * host::cos(5 * v), v, 0);
                const glm::vec3 n(0.2 * host::sin(9 * u), 1, 0.2 * host::cos(8 * v));
                normal(x, y) = glm::vec4(normalize3<float>(n), 1);
            }
        rsm.size = map_size;
        rsm.view.orthographic = true;
        rsm.view.world_to_view = glm::dmat4(0);
        rsm.view.world_to_view[0][0] = rsm.view.world_to_view[2][1] = rsm.view.world_to_view[3][3] = 1;
        rsm.half_records.resize(std::size_t(record_stride) * map_size * map_size);
        rsm.records.resize(rsm.half_records.size());
        for (int y = 0; y < map_size; ++y)
            for (int x = 0; x < map_size; ++x) {
                const double u = (x + 0.5) / map_size * 2 - 1, v = (y + 0.5) / map_size * 2 - 1;
                const float bump = 0.01f * unit_float<float>(pixel_hash<std::int32_t>(x, y, 0, 1).x);
                const glm::vec3 n =
                    normalize3<float>(glm::vec3(0.4 * host::cos(19 * u), -0.8, 0.3 * host::sin(28 * v)));
                const float record[record_stride] = {
                    float(u), 0.3f + bump + float(0.05 * host::sin(17 * u) * host::cos(25 * v)), float(v), 1, n.x, n.y,
                    n.z, 0, 1e-4f, 0.5e-4f, 0.25e-4f, 0};
                for (int c = 0; c < record_stride; ++c) {
                    const std::size_t i = std::size_t(record_stride) * (std::size_t(y) * map_size + x) + c;
                    rsm.half_records[i] = float_to_half(record[c]);
                    rsm.records[i] = half_to_float(rsm.half_records[i]);
                }
            }
    }
};

Scene& scene() {
    static Scene s;
    return s;
}

void disc(benchmark::State& state, bool half, Isa isa, int threads) {
    Scene& s = scene();
    s.rsm.half = half;
    rsm::GatherParams params{.gather = rsm::Gather::disc};
    params.samples = samples;
    const rsm::Pattern pattern = rsm::disc_pattern(params, map_size, 1);
    RunOptions options;
    options.isa = isa;
    options.threads = threads;
    Image4 irradiance;
    for (auto _ : state) {
        rsm::run(params, {&s.position, &s.normal, &s.rsm, &pattern, 1}, options, irradiance);
        benchmark::DoNotOptimize(irradiance.data());
    }
    // Reported as seconds a sample on all threads together; times `threads` it is seconds a sample of one core.
    state.counters["per_sample"] =
        benchmark::Counter(double(frame) * frame * samples,
                           benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

[[maybe_unused]] const bool registered = [] {
    for (bool half : {true, false})
        for (Isa isa : supported_isas())
            for (int threads : {1, 2}) {
                const std::string name = std::string("rsm.disc/") + (half ? "rgba16f/" : "fp32/") + isa_name(isa) +
                                         "/threads:" + std::to_string(threads);
                benchmark::RegisterBenchmark(name.c_str(), disc, half, isa, threads)
                    ->Unit(benchmark::kMillisecond)
                    ->UseRealTime()
                    ->MinTime(0.2);
            }
    return true;
}();

}  // namespace

BENCHMARK_MAIN();
