// One update of irradiance probes from their hits to the lightmap, stage by stage, the last three in turn and all five, and beside them
// a copy of as many bytes as the last three move: how fast the machine's memory is. By instruction set, on one and on two threads.
//
//     tools/bench probes --benchmark_filter=update
//
// `tools/bench twins --update` measures the same beside twins, and a copy in turns with it.
// Bytes by the second: each input read once, each output written once; of the copy what it reads and what it writes.
#include <benchmark/benchmark.h>

#include <cstring>
#include <map>
#include <memory>
#include <string>

#include "core/parallel.h"
#include "tools/bench_stages/update_work.h"

namespace {

using namespace plumb;
using bench::UpdateSize;
using bench::UpdateWork;

const UpdateWork& work_of(const UpdateSize& size) {
    static std::map<int, std::unique_ptr<UpdateWork>> all;
    auto& work = all[size.receivers];
    if (!work) work = std::make_unique<UpdateWork>(size);
    return *work;
}

// A dispatch, bound, with memory for its output.
struct Bound {
    const StageBinding& binding;
    StageData data;
    std::unique_ptr<BoundStage> stage = binding.bind(data);
    Bundle outputs = make_outputs(binding, data);

    double bytes() const {
        double sum = 0;
        for (const Array& a : data.inputs.arrays) sum += double(std::as_const(a.bytes).size());
        for (const Array& a : outputs.arrays) sum += double(std::as_const(a.bytes).size());
        return sum;
    }
};

enum Part { part_radiance, part_lambda, part_basis, part_irradiance, part_lightmap, part_three, part_all };
constexpr const char* part_names[] = {"radiance", "lambda", "basis", "irradiance", "lightmap", "last_three", "update"};

std::vector<std::unique_ptr<Bound>> parts_of(const UpdateWork& w, Part part) {
    std::vector<std::unique_ptr<Bound>> all;
    const auto add = [&](Part of, const StageBinding& binding, StageData data) {
        if (part == of || part == part_all || (part == part_three && of >= part_basis)) all.emplace_back(new Bound{binding, std::move(data)});
    };
    add(part_radiance, stage<probes::RadianceKernel>(), w.radiance());
    add(part_lambda, stage<probes::LambdaKernel>(), w.lambda());
    add(part_basis, stage<probes::BasisKernel>(), w.basis());
    add(part_irradiance, stage<probes::IrradianceKernel>(), w.irradiance());
    add(part_lightmap, stage<probes::LightmapKernel>(), w.lightmap());
    return all;
}

void report(benchmark::State& state, double bytes) {
    state.counters["bytes"] = benchmark::Counter(bytes, benchmark::Counter::kIsIterationInvariantRate, benchmark::Counter::kIs1000);
    state.counters["moved"] = benchmark::Counter(bytes, benchmark::Counter::kDefaults, benchmark::Counter::kIs1000);
}

void run_part(benchmark::State& state, const UpdateSize& size, Part part, Isa isa, int threads) {
    const auto parts = parts_of(work_of(size), part);
    RunOptions options;
    options.isa = isa, options.threads = threads;
    double bytes = 0;
    for (const auto& p : parts) bytes += p->bytes();
    for (auto _ : state) {
        for (const auto& p : parts) p->stage->run(options, {}, p->outputs);
        benchmark::DoNotOptimize(parts[0]->outputs.arrays[0].bytes.data());
    }
    report(state, bytes);
}

// As many bytes as the last three stages move: half of them read, half of them written.
void run_copy(benchmark::State& state, const UpdateSize& size, int threads) {
    double bytes = 0;
    for (const auto& p : parts_of(work_of(size), part_three)) bytes += p->bytes();
    constexpr int piece = 1 << 16;
    const int pieces = int(bytes / 2 / piece);
    const Buffer<unsigned char> from(std::size_t(pieces) * piece, 1);
    Buffer<unsigned char> to(from.size(), 2);
    for (auto _ : state) {
        parallel_bands(pieces, 4, threads, [&](int first, int last) {
            std::memcpy(&to[std::size_t(first) * piece], &from[std::size_t(first) * piece], std::size_t(last - first) * piece);
        });
        benchmark::DoNotOptimize(to.data());
    }
    report(state, 2.0 * double(from.size()));
}

[[maybe_unused]] const bool registered = [] {
    const auto add = [](const std::string& name, auto run) {
        benchmark::RegisterBenchmark(name.c_str(), run)->Unit(benchmark::kMillisecond)->UseRealTime()->MinTime(0.2);
    };
    for (const UpdateSize& size : bench::update_sizes)
        for (const int threads : {1, 2}) {
            const auto named = [&](const std::string& what) {
                return "probes.update/" + std::to_string(size.receivers) + "/" + what + "/threads:" + std::to_string(threads);
            };
            add(named("copy"), [size, threads](benchmark::State& state) { run_copy(state, size, threads); });
            for (const Part part : {part_radiance, part_lambda, part_basis, part_irradiance, part_lightmap, part_three, part_all})
                for (const Isa isa : supported_isas())
                    add(named(std::string(part_names[part]) + "/" + isa_name(isa)),
                        [size, part, isa, threads](benchmark::State& state) { run_part(state, size, part, isa, threads); });
        }
    return true;
}();

}  // namespace
