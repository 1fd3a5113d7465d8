// Times of repeated runs, taken in turns so that whatever else the machine does falls on both sides.
#pragma once

#include <functional>
#include <vector>

namespace plumb::bench {

struct Times {
    std::vector<double> ms;
    std::vector<double> cpu_ms;  // of all threads of the process: what it costs, whoever else computes meanwhile

    double median() const;
    double least() const;
    double cpu_median() const;
};

double clock_ms(const std::function<void()>& work);

// Runs every side once to warm it, then all of them in turns; each returns its milliseconds.
std::vector<Times> interleave(int runs, const std::vector<std::function<double()>>& sides);

// Bytes of this process in memory: now, and at most since the last reset.
std::size_t resident_bytes();
std::size_t peak_bytes();
void reset_peak();  // gives free memory back to the system first

}  // namespace plumb::bench
