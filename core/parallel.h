// Parallel loops over a fixed partition. A band of rows belongs to one task, whatever the number of threads, so no
// result can depend on the scheduler.
#pragma once

#include <functional>

#include "core/isa.h"

namespace plumb {

// Calls body(first, last) for bands [first, last) of at most `band` rows that cover [0, rows). The floating-point
// environment is set around every call. threads = 0: all processors.
void parallel_bands(int rows, int band, int threads, const std::function<void(int first, int last)>& body);

// The same with the threads of `options`, telling its progress.
void parallel_bands(int rows, int band, const RunOptions& options,
                    const std::function<void(int first, int last)>& body);

// The number of threads that `threads` stands for.
int thread_count(int threads);

}  // namespace plumb
