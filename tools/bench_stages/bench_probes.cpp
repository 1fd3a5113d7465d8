// The stages of a bake of probes, on the Cornell box: 78 probes, 10 of them a receiver, 512 rays, degree 7. A block of 1024
// receivers for probes.share and probes.coefficients, a dispatch of 32,767 receivers for probes.supports, the first candidates of
// the box for probes.density; all rays of all probes for probes.radiance and probes.lambda. By instruction set, on one and on two
// threads.
// the box for probes.density, a picture for probes.volume. By instruction set, on one and on two threads.
//
//     tools/bench probes
//
// Beside the time, by the second: bytes that a stage must move at least (each input read once, each output written once), and
// operations (a sum, a product, a division, a root are one each) of the sums as they are written, but of what no probe sees.
#include <benchmark/benchmark.h>

#include <bit>
#include <string>

#include "core/sh.h"
#include "gi/frame/settings.h"
#include "gi/lend.h"
#include "gi/probes/bake.h"
#include "gi/probes/coefficients.h"
#include "gi/probes/density.h"
#include "gi/probes/lambda.h"
#include "gi/probes/radiance.h"
#include "gi/probes/indirect_shadow.h"
#include "gi/probes/level.h"
#include "gi/probes/relief.h"
#include "gi/probes/share.h"
#include "gi/probes/volume.h"
#include "io/scene_file.h"

namespace {

using namespace plumb;

// A bake up to its supports, and a block of receivers, traced.
struct Box {
    Scene scene = io::load_scene(PLUMB_SOURCE_DIR "/data/scenes/cornell/cornell.toml", frame::method_tables());
    probes::BakeGraph graph{scene, params()};
    probes::TracedBlock block;
    Buffer<float> factors;
    std::vector<std::int32_t> rows;
    probes::SupportsInputs supports;

    static probes::BakeParams params() {
        probes::BakeParams p;
        p.placement.overlaps = 10, p.placement.least = 8, p.receiver_rays = 512, p.gather = probes::Gather::interpolated;
        p.lightmap_size = 309, p.placement.count = 78;  // 65,520 receivers: column P4 of `plumb experiment probes`
        return p;
    }
    Box() {
        const std::vector<const graph::Node*> steps = graph.nodes_before_rays();
        graph::run(steps, {});
        const probes::Bake& bake = graph.bake();
        block = graph.traced(bake.receivers.count() / 2, {});
        factors = probes::ray_factors(probes::receiver_directions(block.rays, bake.transport.distribution),
                                      bake.transport.distribution);
        rows = probes::coefficient_rows(block.slots, bake.params.degree);
        supports.receivers = &bake.receivers.position, supports.probes = &bake.placement.probes;
        supports.radius = float(bake.radius.radius_m), supports.overlaps = bake.params.placement.overlaps;
    }

    StageData density() const {
        const probes::Placement& p = graph.bake().placement;
        return probes::data_of(probes::DensityInputs{&p.candidates, float(p.rho_m)});
    }
    // As many boxes as a bake of 512,026 receivers has clusters and probes; every other is of the side's zone.
    StageData level() const {
        static Buffer<glm::vec4> low, high;
        for (int i = int(low.size()); i < 1024; ++i) {
            const float x = 0.1f * float(i);
            low.push_back({x, 0, i % 2 ? 0.0f : -x, 0.5f}), high.push_back({x + 4, 4, i % 2 ? 4.0f : 4 - x, 0});
        }
        probes::LevelRule rule;
        rule.levels = 4, rule.distances = {10, 20, 40, 0}, rule.margins = {1, 2, 4, 0};
        rule.zones = {0.5f, 0.8660254f, -0.5f, 0.8660254f}, rule.scales = {1, 2, 4, 0};
        return probes::data_of(probes::LevelInputs{&low, &high, rule});
    }
    StageData supporting() const {
        return probes::data_of(supports, 0, std::min(graph.bake().receivers.count(), probes::receivers_a_dispatch));
    }
    StageData share(bool published) const {
        return probes::data_of(probes::ShareInputs{block.count, block.rays, block.slots, published, block.supporting.data(),
                                                   factors.data(), block.visible.data(), block.lengths.data()});
    }
    StageData coefficients() const {
        return probes::data_of(probes::CoefficientsInputs{block.count, block.rays, block.slots, graph.bake().params.degree, rows.data(),
                                                          block.supporting.data(), block.seen.data(), block.visible.data(),
                                                          block.shares.data()});
    }
};
const Box& box() {
    static const Box b;
    return b;
}

// What all rays of all probes of the box end on, under a direct light and a lightmap of one radiance; and what they bring.
struct Relight {
    Buffer<glm::vec4> surface, emitted, direct, place, radiance;
    Image4 lightmap;
    Buffer<float> harmonics, weights;
    std::vector<std::int32_t> level;
    probes::RadianceInputs rays;
    probes::LambdaInputs sums;

    Relight() {
        const probes::Bake& bake = box().graph.bake();
        const Buffer<glm::vec4> directions = probes::relight_directions(bake.params.relight_rays);
        const probes::RelightHits hits =
            probes::relight_rays(bake.atlas, raster::surface_args(bake.atlas.geometry, box().graph.surfaces(), View{}),
                                 box().graph.query(), bake.placement.probes, directions, {});
        for (std::size_t i = 0; i < hits.material.size(); ++i) {
            const bool front = hits.material[i] >= 0;
            surface.push_back(front ? glm::vec4(0.5f, 0.5f, 0.5f, 1) : glm::vec4(0));
            emitted.emplace_back(0.1f, 0.1f, 0.1f, 0), direct.emplace_back(1, 1, 1, 0), place.emplace_back(hits.uv[i], 0, 0);
        }
        lightmap = Image4(bake.atlas.size.x, bake.atlas.size.x, glm::vec4(2, 2, 2, 1));
        rays.probes = hits.probes, rays.rays = hits.rays, rays.side = lightmap.width;
        rays.surface = &surface, rays.emitted = &emitted, rays.direct = &direct, rays.place = &place, rays.lightmap = &lightmap;
        run(rays, {}, radiance);
        harmonics = probes::harmonics_of(directions, bake.params.degree), weights = probes::level_weights(directions, {hits.rays});
        level.assign(std::size_t(hits.probes), 0);
        sums.probes = hits.probes, sums.rays = hits.rays, sums.coefficients = sh::count(bake.params.degree);
        sums.level_rays = {hits.rays}, sums.level_coefficients = {sums.coefficients};
        sums.radiance = &radiance, sums.harmonics = &harmonics, sums.weights = &weights, sums.probe_level = &level;
    }
};
const Relight& relight() {
    static const Relight r;
    return r;
}

struct Work {
    StageData data;
    double operations;
};

// Of all pairs of candidates, near or far: 10 for the distance in radii, 6 for the weight and its sum.
Work density() {
    const double n = double(box().graph.bake().placement.candidates.size());
    return {box().density(), n * n * 16};
}
// Of each pair 8 for its distance; a slot's weight takes 7.
Work supports() {
    const StageData data = box().supporting();
    return {data, double(data.size.y) * (8.0 * double(box().graph.bake().placement.probes.size()) + 7.0 * data.size.x)};
}
// Of each box: 6 for the corners from the eye, 6 for the gap, 6 for its length, 18 for centre and radius, 22 for the zone, 9 for the
// distances that are compared.
Work level() { return {box().level(), 67.0 * 1024}; }
// Of each ray a sum over slots, a product and a quotient; W(x) takes 4 more.
Work share(bool published) {
    const probes::TracedBlock& b = box().block;
    return {box().share(published), double(b.rays) * b.count * (b.slots + 2.0 + (published ? 4 : 0))};
}
// Of each ray that a probe sees: 16 for direction and weight; 6 for each of 8 powers, 4 for each of 28 steps of the recurrence, 2
// for each of 64 sums.
Work coefficients() {
    double seen = 0;
    for (const std::int32_t bits : box().block.visible) seen += std::popcount(std::uint32_t(bits));
    return {box().coefficients(), seen * (16 + 6 * 8 + 4 * 28 + 2 * 64)};
}

// Of each ray 15 for what comes of direct light and the lightmap, 12 for its place, 27 for the texels around it.
Work radiance() { return {probes::data_of(relight().rays), double(relight().surface.size()) * (15 + 12 + 27)}; }
// A product and a sum of each coefficient, ray and channel, and a weight of each ray and channel.
Work lambda() {
    const probes::LambdaInputs& in = relight().sums;
    return {probes::data_of(in), double(in.probes) * in.rays * 3 * (2 * in.coefficients + 1)};
}
// 512 x 512 points all over a grid of 12 x 12 x 10 places, none with a lightmap. Of each place of the cell a weight of 2, and 36 for
// its sums; 2 x 60 for the two irradiances, 60 for the light vector and the cell.
Work volume() {
    const int side = 512;
    static Image4 position(side, side), normal(side, side);
    static const Image4 uv(side, side, glm::vec4(-1));
    static const Buffer<glm::vec4> irradiance(12 * 12 * 10 * 6, glm::vec4(1, 2, 3, 0));
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            const float u = float(x) / side, v = float(y) / side;
            position(x, y) = {12 * u, 12 * v, 10 * u * v, 1}, normal(x, y) = {0.6f * (1 - 2 * u), 0.8f, 0.6f * (2 * u - 1), 1};
        }
    probes::VolumeInputs in;
    in.grid = {{12, 12, 10}, {0.5f, 0.5f, 0.5f}, {1, 1, 1}};
    in.position = &position, in.normal = &normal, in.lightmap_uv = &uv, in.irradiance = &irradiance;
    return {probes::data_of(in), double(side) * side * (8 * 38 + 180)};
}

// The same many points, all with a lobe; 70 each, and as many for the power. A spot takes as much again, and 30 for its cone.
Work relief() {
    const int side = 512;
    static const Image4 position(side, side, glm::vec4(1)), up(side, side, glm::vec4(0, 1, 0, 1)), lit(side, side, glm::vec4(2, 1, 3, 1)),
        specular(side, side, glm::vec4(0.25f, 0.5f, 0.1f, 20));
    probes::ReliefInputs in;
    in.eye = {2, 4, 1}, in.position = &position, in.normal = &up, in.irradiance = &lit, in.mapped = &lit, in.plain = &lit;
    in.light = &up, in.from_light = &lit, in.specular = &specular;
    static std::vector<Light> lamps(1);
    static const Buffer<float> visibility(std::size_t(side) * side, 1.0f);
    lamps[0].position = {0, 5, 0};
    in.lights = &lamps, in.visibility = &visibility;
    return {probes::data_of(in), double(side) * side * (140 + 70 + 30)};
}

// Points of a floor under 16 spheres in the air and across its horizon; some 120 a sphere.
Work indirect_shadow() {
    const int side = 512, count = 16;
    static Image4 position(side, side, glm::vec4(0));
    static const Image4 up(side, side, glm::vec4(0, 1, 0, 1)), lit(side, side, glm::vec4(2, 1, 3, 1));
    static const Image<glm::ivec2> id(side, side, glm::ivec2(0));
    static probes::ShadowSpheres spheres;
    for (int y = 0; y < side && spheres.owner.empty(); ++y)
        for (int x = 0; x < side; ++x) position(x, y) = glm::vec4(float(x) / 128, 0, float(y) / 128, 0);
    for (int i = 0; i < count && int(spheres.owner.size()) < count; ++i) {
        spheres.rows.push_back({1.7f + 0.2f * float(i % 4), 0.1f + 0.45f * float(i / 4), 2, 0.25f});
        for (int k = 0; k < 6; ++k) spheres.rows.push_back({0.1f, 0.2f, -0.1f, k < 3 ? 0.5f : 0.1f});
        spheres.owner.push_back({1, 1});
    }
    probes::IndirectShadowInputs in;
    in.position = &position, in.normal = &up, in.irradiance = &lit, in.id = &id, in.spheres = &spheres;
    return {probes::data_of(in), double(side) * side * count * 120};
}

double bytes_of(const StageBinding& binding, const StageData& data) {
    double bytes = 0;
    for (const Array& a : data.inputs.arrays) bytes += double(std::as_const(a.bytes).size());
    for (const Slot& slot : binding.outputs) bytes += 4.0 * slot.channels * data.size.x * data.size.y;
    return bytes;
}

void run_stage(benchmark::State& state, const StageBinding& binding, Work (*make)(), Isa isa, int threads) {
    const Work work = make();
    RunOptions options;
    options.isa = isa, options.threads = threads;
    const auto bound = binding.bind(work.data);
    Bundle outputs = make_outputs(binding, work.data);
    for (auto _ : state) {
        bound->run(options, {}, outputs);
        benchmark::DoNotOptimize(outputs.arrays[0].bytes.data());
    }
    const auto rate = benchmark::Counter::kIsIterationInvariantRate;
    state.counters["bytes"] = benchmark::Counter(bytes_of(binding, work.data), rate, benchmark::Counter::kIs1000);
    state.counters["operations"] = benchmark::Counter(work.operations, rate, benchmark::Counter::kIs1000);
}

[[maybe_unused]] const bool registered = [] {
    struct Stage {
        const char* name;
        const StageBinding& (*binding)();
        Work (*work)();
    };
    static const Stage stages[] = {{"density", stage<probes::DensityKernel>, density},
                                   {"supports", stage<probes::SupportsKernel>, supports},
                                   {"level", stage<probes::LevelKernel>, level},
                                   {"share", stage<probes::ShareKernel>, [] { return share(false); }},
                                   {"share_published", stage<probes::ShareKernel>, [] { return share(true); }},
                                   {"coefficients", stage<probes::CoefficientsKernel>, coefficients},
                                   {"radiance", stage<probes::RadianceKernel>, radiance},
                                   {"lambda", stage<probes::LambdaKernel>, lambda},
                                   {"volume", stage<probes::VolumeKernel>, volume},
                                   {"indirect_shadow", stage<probes::IndirectShadowKernel>, indirect_shadow},
                                   {"relief", stage<probes::ReliefKernel>, relief}};
    for (const Stage& s : stages)
        for (const Isa isa : supported_isas())
            for (const int threads : {1, 2}) {
                const std::string name = std::string("probes.") + s.name + "/" + isa_name(isa) + "/threads:" + std::to_string(threads);
                benchmark::RegisterBenchmark(name.c_str(), [s, isa, threads](benchmark::State& state) {
                    run_stage(state, s.binding(), s.work, isa, threads);
                })->Unit(benchmark::kMillisecond)->UseRealTime()->MinTime(0.2);
            }
    return true;
}();

}  // namespace
