#include "tools/bench_raster/measure.h"

#include <malloc.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <string>

namespace plumb::bench {
namespace {

// A field of /proc/self/status, in kilobytes there.
std::size_t status_bytes(const std::string& field) {
    std::ifstream in("/proc/self/status");
    for (std::string line; std::getline(in, line);)
        if (line.compare(0, field.size() + 1, field + ":") == 0)
            return 1024 * std::stoull(line.substr(field.size() + 1));
    return 0;
}

}  // namespace

double Times::median() const {
    std::vector<double> sorted = ms;
    std::sort(sorted.begin(), sorted.end());
    const std::size_t n = sorted.size();
    return n == 0 ? 0 : (sorted[(n - 1) / 2] + sorted[n / 2]) / 2;
}

double Times::least() const { return ms.empty() ? 0 : *std::min_element(ms.begin(), ms.end()); }

double clock_ms(const std::function<void()>& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

std::vector<Times> interleave(int runs, const std::vector<std::function<double()>>& sides) {
    std::vector<Times> times(sides.size());
    for (const auto& side : sides) side();
    for (int run = 0; run < runs; ++run)
        for (std::size_t i = 0; i < sides.size(); ++i) times[i].ms.push_back(sides[i]());
    return times;
}

std::size_t resident_bytes() { return status_bytes("VmRSS"); }
std::size_t peak_bytes() { return status_bytes("VmHWM"); }

void reset_peak() {
    malloc_trim(0);
    std::ofstream("/proc/self/clear_refs") << "5";
}

}  // namespace plumb::bench
