// Every stage of a frame but the gather: 1024^2 pixels, a map of 512^2 texels, by instruction set, on one thread.
//
//     plumb_bench --benchmark_filter=frame --benchmark_repetitions=9 --benchmark_enable_random_interleaving=true
#include <benchmark/benchmark.h>

#include <string>

#include "core/host_math.h"
#include "gi/frame/frame.h"
#include "raster/bindings.h"

namespace {

using namespace plumb;

// A floor of n x n quads with waves in it, under a spot.
Scene waves(int n) {
    Scene s;
    s.name = "waves";
    s.materials.resize(1);
    Mesh mesh;
    for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i) {
            const double x = 2.0 * i / n - 1, z = 2.0 * j / n - 1;
            const glm::vec3 normal(-0.4 * host::cos(8 * x), 1, 0.25 * host::sin(5 * z));
            mesh.vertices.push_back({glm::vec3(x, 0.05 * host::sin(8 * x) + 0.05 * host::cos(5 * z), z), float(x),
                                     normalize3<float>(normal), float(z)});
        }
    for (unsigned j = 0; j < unsigned(n); ++j)
        for (unsigned i = 0; i < unsigned(n); ++i) {
            const unsigned a = j * (n + 1) + i, b = a + n + 1;
            mesh.triangles.push_back(glm::uvec3(a, b, a + 1));
            mesh.triangles.push_back(glm::uvec3(a + 1, b, b + 1));
        }
    mesh.material.assign(mesh.triangles.size(), 0);
    s.meshes.push_back(std::move(mesh));
    Light spot;
    spot.name = "key";
    spot.position = {0, 2, 0};
    s.lights.push_back(spot);
    s.camera.position = {0, 1.2, 2};
    return s;
}

void stage(benchmark::State& state, const std::string& name, Isa isa) {
    static const Scene scene = waves(280);  // 156,800 triangles
    static const frame::Settings settings = [] {
        frame::Settings s;
        s.rsm.samples = 1;
        return s;
    }();
    static const frame::Plan plan = frame::plan(scene, settings);
    RunOptions options;
    options.isa = isa;
    options.threads = 1;
    for (auto _ : state) {
        const frame::Frame f = frame::execute(scene, settings, plan, options);
        for (std::size_t i = 0; i < plan.stages.size(); ++i)
            if (plan.stages[i].name == name) state.SetIterationTime(f.stages[i].ms * 1e-3);
    }
}

[[maybe_unused]] const bool registered = [] {
    for (const std::string& name : {raster::gbuffer_binding().info.name, std::string("rsm"), std::string("shadow"), std::string("direct"),
                                    std::string("compose"), std::string("tonemap")})
        for (Isa isa : supported_isas())
            benchmark::RegisterBenchmark((std::string("frame/") + name + "/" + isa_name(isa)).c_str(), stage, name, isa)
                ->Unit(benchmark::kMillisecond)
                ->UseManualTime()
                ->Iterations(2);
    return true;
}();

}  // namespace
