// Stages as benchmarks: each by every instruction set, on one thread.
#pragma once

#include <benchmark/benchmark.h>

#include <string>
#include <vector>

#include "core/binding.h"
#include "core/isa.h"

namespace plumb::bench {

struct IsaStage {
    const char* name;  // after the method's
    const StageBinding& (*binding)();
};

// "<method>.<stage>/<instruction set>"; data_at(stage): what it reads, which is made when the benchmark runs.
inline void add_stages(const std::string& method, const std::vector<IsaStage>& stages, StageData (*data_at)(const std::string& stage)) {
    for (const Isa isa : supported_isas())
        for (const IsaStage& s : stages)
            benchmark::RegisterBenchmark((method + "." + s.name + "/" + isa_name(isa)).c_str(), [s, isa, data_at](benchmark::State& state) {
                RunOptions options;
                options.isa = isa, options.threads = 1;
                const StageData data = data_at(s.name);
                const auto bound = s.binding().bind(data);
                Bundle outputs = make_outputs(s.binding(), data);
                for (auto _ : state) {
                    bound->run(options, {}, outputs);
                    benchmark::DoNotOptimize(outputs.arrays[0].bytes.data());
                }
            })->Unit(benchmark::kMillisecond)->UseRealTime()->MinTime(0.2);
}

}  // namespace plumb::bench
