#include "tools/shared/announce.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>

#include "core/parallel.h"

namespace plumb::cli {

std::string about(double seconds) {
    const bool hours = seconds >= 5400, minutes = !hours && seconds >= 90;
    const double number = seconds / (hours ? 3600 : minutes ? 60 : 1);
    const double rounded = number < 10 ? std::round(number) : number < 100 ? 5 * std::round(number / 5) : 50 * std::round(number / 50);
    return fmt::format("about {:g} {}", rounded, hours ? "hours" : minutes ? "minutes" : "s");
}

void announce(const std::string& what, double core_seconds, const RunOptions& options) {
    const int threads = thread_count(options.threads);
    const double seconds = core_seconds / threads;
    if (!(seconds >= 20)) return;
    fmt::print(stderr, "{}: {} on {} thread{}\n", what, about(seconds), threads, threads == 1 ? "" : "s");
}

}  // namespace plumb::cli
