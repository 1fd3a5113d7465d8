#include "tools/bench_raster/measure.h"

#include <malloc.h>
#include <time.h>

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

double median_of(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    const std::size_t n = values.size();
    return n == 0 ? 0 : (values[(n - 1) / 2] + values[n / 2]) / 2;
}

double cpu_clock_ms() {
    timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return double(t.tv_sec) * 1e3 + double(t.tv_nsec) * 1e-6;
}

}  // namespace

double Times::median() const { return median_of(ms); }

double Times::cpu_median() const { return median_of(cpu_ms); }

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
        for (std::size_t i = 0; i < sides.size(); ++i) {
            const double start = cpu_clock_ms();
            times[i].ms.push_back(sides[i]());
            times[i].cpu_ms.push_back(cpu_clock_ms() - start);
        }
    return times;
}

std::size_t resident_bytes() { return status_bytes("VmRSS"); }
std::size_t peak_bytes() { return status_bytes("VmHWM"); }

void reset_peak() {
    malloc_trim(0);
    std::ofstream("/proc/self/clear_refs") << "5";
}

}  // namespace plumb::bench
