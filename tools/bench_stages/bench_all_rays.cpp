// RSM gather with shadow rays on the Cornell box, 96^2 pixels by a map of 64^2 texels: every lit texel, whose rays stay
// together, and subsets of 256 texels a pixel, whose rays scatter. Rays a second, by ray query and number of threads.
//
//     plumb_bench --benchmark_filter=rsm.all_rays --benchmark_repetitions=9 --benchmark_enable_random_interleaving=true
#include <benchmark/benchmark.h>

#include <map>
#include <memory>
#include <string>

#include "gi/frame/frame.h"
#include "gi/reference/ray_query.h"
#include "gi/rsm/all_rays.h"
#include "io/scene_file.h"

namespace {

using namespace plumb;

constexpr int pixels = 96, texels = 64, subset = 256;

// The G-buffer and the maps, drawn once, and a ray query of each kind.
struct Box {
    Scene scene = io::load_scene(std::string(PLUMB_SOURCE_DIR) + "/data/scenes/cornell/cornell.toml",
                                 frame::method_tables());
    frame::Settings settings;
    frame::Frame frame;
    Geometry geometry;
    raster::Surfaces surfaces;
    std::map<Rays, std::unique_ptr<RayQuery>> rays;
    rsm::RayOffsets offsets;

    Box() {
        scene.frame_size = {pixels, pixels};
        scene.lights.at(0).rsm_size = texels;
        frame::Settings direct;
        direct.method = frame::Method::direct;
        direct.pruning = false;  // the map is wanted with its flux
        frame = frame::execute(scene, direct, frame::plan(scene, direct), {});
        geometry = flatten(scene);
        surfaces = raster::prepare(scene, geometry);
        for (Rays kind : {Rays::exact, Rays::native})
            rays[kind] = reference::build_ray_query(geometry, surfaces, kind);
        settings.rsm.gather = rsm::Gather::all_rays;
        glm::vec3 low(0), high(0);
        bounds(geometry, low, high);
        const View view = make_view(scene.camera, 1, scene.convention, scene.frame_size);
        offsets = rsm::ray_offsets(settings.layout, low, high, view, scene.frame_size);
    }
};

void all_rays(benchmark::State& state, Rays kind, float max_rays, Isa isa, int threads) {
    static const Box box;
    frame::Settings settings = box.settings;
    settings.rsm.max_rays = max_rays;
    RunOptions options;
    options.isa = isa, options.threads = threads;
    const rsm::Pattern none;
    Image4 irradiance;
    rsm::RaysReport report;
    for (auto _ : state) {
        rsm::GatherInputs in{&box.frame.gbuffer.position, &box.frame.gbuffer.normal, nullptr, &none, settings.seed};
        in.rays = box.rays.at(kind).get(), in.offsets = box.offsets;
        rsm::run_maps(settings.rsm, in, box.frame.rsms[0], options, irradiance, &report);
        benchmark::DoNotOptimize(irradiance.data());
    }
    state.counters["rays"] =
        benchmark::Counter(double(report.traced), benchmark::Counter::kIsIterationInvariantRate);
}

[[maybe_unused]] const bool registered = [] {
    for (Rays kind : {Rays::exact, Rays::native})
        for (bool part : {false, true})
            for (Isa isa : {Isa::avx2, Isa::avx512})
                for (int threads : {1, 2}) {
                    if (isa > best_isa()) continue;
                    const std::string name = std::string("rsm.all_rays/") + (kind == Rays::exact ? "exact/" : "native/") +
                                             (part ? "subset/" : "every/") + isa_name(isa) +
                                             "/threads:" + std::to_string(threads);
                    const float max_rays = part ? float(pixels) * pixels * subset : 0;
                    benchmark::RegisterBenchmark(name.c_str(), all_rays, kind, max_rays, isa, threads)
                        ->Unit(benchmark::kMillisecond)
                        ->MeasureProcessCPUTime()
                        ->UseRealTime()
                        ->Iterations(1);
                }
    return true;
}();

}  // namespace
