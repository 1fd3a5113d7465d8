#include "core/parallel.h"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>

#include "core/fp_environment.h"

namespace plumb {

int thread_count(int threads) { return threads > 0 ? threads : tbb::info::default_concurrency(); }

void parallel_bands(int rows, int band, int threads, const std::function<void(int, int)>& body) {
    const int bands = (rows + band - 1) / band;
    auto run = [&](int i) {
        FpEnvironment environment;
        body(i * band, std::min(rows, (i + 1) * band));
    };
    const int n = thread_count(threads);
    if (n == 1) {
        for (int i = 0; i < bands; ++i) run(i);
        return;
    }
    // More threads than processors are allowed on request: --threads 3 on two cores is a test of the partition.
    tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                              std::max(n, tbb::info::default_concurrency()));
    tbb::task_arena arena(n);
    arena.execute([&] {
        tbb::parallel_for(
            tbb::blocked_range<int>(0, bands, 1),
            [&](const tbb::blocked_range<int>& range) {
                for (int i = range.begin(); i < range.end(); ++i) run(i);
            },
            tbb::simple_partitioner());
    });
}

void parallel_bands(int rows, int band, const RunOptions& options, const std::function<void(int, int)>& body) {
    std::atomic<int> done{0};
    parallel_bands(rows, band, options.threads, [&](int first, int last) {
        body(first, last);
        const int now = done += last - first;
        if (options.progress) options.progress(double(now) / rows);
    });
}

}  // namespace plumb
