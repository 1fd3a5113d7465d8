// The filters of indirect light at 512^2 pixels: kernel 17 full and separable, both similarities; reduce and upsample; and
// that of a light's shadows, rows and columns together; by instruction set, on one and on two threads.
//
//     plumb_bench --benchmark_filter=filter --benchmark_repetitions=9 --benchmark_enable_random_interleaving=true
#include <benchmark/benchmark.h>

#include <string>

#include "gi/direct/visibility_filter.h"
#include "gi/filter/filter.h"

namespace {

using namespace plumb;

constexpr int side = 512;

// A wall with ridges, 2 m away.
struct Wall {
    Image4 position{side, side}, normal{side, side, glm::vec4(0, 0, 1, 1)}, irradiance{side, side};
    Image4 half_position, half_normal, half_irradiance;

    Wall() {
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x) {
                position(x, y) = {0.005f * float(x), 0.005f * float(y), 0.01f * float((7 * x + 3 * y) % 5), 2};
                irradiance(x, y) = {float(x * y % 13), 1, 2, 2};
            }
        const filter::FilterParams params;
        filter::run(params, filter::ReduceInputs{&position}, {}, half_position);
        filter::run(params, filter::ReduceInputs{&normal}, {}, half_normal);
        filter::run(params, filter::ReduceInputs{&irradiance}, {}, half_irradiance);
    }
};

void run(benchmark::State& state, const std::string& what, filter::FilterParams params, Isa isa, int threads) {
    static const Wall wall;
    RunOptions options;
    options.isa = isa, options.threads = threads;
    Image4 out;
    for (auto _ : state) {
        if (what == "reduce")
            filter::run(params, filter::ReduceInputs{&wall.position}, options, out);
        else if (what == "upsample")
            filter::run(params, filter::UpsampleInputs{&wall.half_irradiance, &wall.half_position, &wall.half_normal, &wall.position, &wall.normal},
                        options, out);
        else
            filter::run_blur(params, {&wall.irradiance, &wall.position, &wall.normal}, options, out);
        benchmark::DoNotOptimize(out.data());
    }
}

void run_shadows(benchmark::State& state, direct::VisibilityFilter filter, Isa isa, int threads) {
    static const Wall wall;
    static const Buffer<float> visibility = [] {
        Buffer<float> half(wall.position.size());
        for (std::size_t i = 0; i < half.size(); ++i) half[i] = i % 5 < 3 ? 1.0f : 0.25f;
        return half;
    }();
    direct::ShadowParams params;
    params.filter = filter;
    RunOptions options;
    options.isa = isa, options.threads = threads;
    Buffer<float> out(visibility.size());
    for (auto _ : state) {
        direct::filter_visibility(params, {visibility.data(), &wall.position, &wall.normal}, options, out.data());
        benchmark::DoNotOptimize(out.data());
    }
}

[[maybe_unused]] const bool registered = [] {
    for (const Isa isa : supported_isas())
        for (const int threads : {1, 2}) {
            auto add = [&](const std::string& what, const filter::FilterParams& params) {
                const std::string name = "filter/" + what + "/" + isa_name(isa) + "/" + std::to_string(threads);
                benchmark::RegisterBenchmark(name.c_str(), run, what, params, isa, threads)
                    ->Unit(benchmark::kMillisecond)
                    ->UseRealTime();
            };
            for (const auto& [what, filter] : {std::pair("shadows", direct::VisibilityFilter::gaussian),
                                               std::pair("shadows_edge_aware", direct::VisibilityFilter::edge_aware)})
                benchmark::RegisterBenchmark(
                    (std::string("filter/") + what + "/" + isa_name(isa) + "/" + std::to_string(threads)).c_str(),
                    run_shadows, filter, isa, threads)
                    ->Unit(benchmark::kMillisecond)
                    ->UseRealTime();
            filter::FilterParams params;
            add("reduce", params), add("upsample", params);
            params.blur = filter::Blur::full;
            add("blur", params);
            params.similarity = filter::Similarity::depth;
            add("blur_by_depth", params);
            params.similarity = filter::Similarity::plane, params.blur = filter::Blur::separable;
            add("blur_separable", params);
        }
    return true;
}();

}  // namespace
