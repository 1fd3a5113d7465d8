// plumb experiment hemicube: the benchmark and the plates of HEM (5.8, appendix C) again, each row with the error that the thesis
// lacks, and what its choices cost: one picture in place of a hemicube (4.5.3), buffers of 8 bits (5.7), multiplier maps (5.5), a
// fixed number of passes (4.5.4).
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/isa.h"
#include "tools/experiments/ipr_sheet.h"

namespace plumb::cli {

inline constexpr std::array<const char*, 7> hemicube_parts = {"complexity", "sizes", "rows", "plates", "projections", "buffers", "solvers"};

struct HemicubeRequest {
    std::set<std::string> parts;    // empty: all
    bool quick = false;             // small meshes and hemicubes: to see that all of it works
    int samples = 2048;             // paths of the truth, at an element
    int elements = 512;             // held against the truth, at most
    int pixel_samples = 256;        // paths of the truth, at a pixel of plates C.9 and C.10
    glm::ivec2 size{256, 256};      // of plates, pixels
    int repeats = 3;                // whose median is a time, where one takes less than two seconds
    bool wants(const char* part) const { return parts.empty() || parts.count(part) > 0; }
};

// As the benchmark counts its scene (HEM 5.8).
struct BenchmarkMesh {
    int factor, vertices, triangles, passes;
};
inline constexpr std::array<BenchmarkMesh, 4> benchmark_meshes = {{{20, 774, 1200, 10}, {10, 2734, 4800, 10}, {5, 10254, 19200, 10}, {4, 15814, 30000, 10}}};
inline constexpr std::array<int, 6> benchmark_sizes = {8, 16, 64, 128, 256, 512};  // 5 passes
inline constexpr double thesis_c9_seconds = 58, thesis_c10_seconds = 203;

using Tell = std::function<void(const std::string&)>;
struct Hemicube {
    std::vector<IprSheet> sheets;
    std::string processor, isa;
    int threads = 0;
    double load = 0;  // of the machine before the run, mean of a minute
};
Hemicube measure_hemicube(const HemicubeRequest& request, const RunOptions& options, const Tell& tell);

// b of y = a x^b, by least squares of logarithms; 0 where fewer than two x differ.
double fitted_exponent(const std::vector<double>& x, const std::vector<double>& y);

// hemicube_bench.cpp: tests 1 and 2, comparisons 5.8.1 to 5.8.3.
IprSheet measure_complexity(const HemicubeRequest& request, const RunOptions& options, const Tell& tell);
IprSheet measure_sizes(const HemicubeRequest& request, const RunOptions& options, const Tell& tell);
// hemicube_rows.cpp: a row by hemicubes and by rays, error against time.
IprSheet measure_rows(const HemicubeRequest& request, const RunOptions& options, const Tell& tell);
// x where y, which falls, is `level`, straight in logarithms between the points that there are; none: it is so nowhere.
std::optional<double> where_it_falls_to(const std::vector<double>& x, const std::vector<double>& y, double level);
// hemicube_plates.cpp: plates C.1 to C.8, C.9 and C.10.
std::vector<IprSheet> measure_plates(const HemicubeRequest& request, const RunOptions& options, const Tell& tell);
// hemicube_choices.cpp: 4.5.3, and 5.5 to 5.7.
IprSheet measure_projections(const HemicubeRequest& request, const RunOptions& options, const Tell& tell);
IprSheet measure_buffers(const HemicubeRequest& request, const RunOptions& options, const Tell& tell);
// hemicube_solvers.cpp: error against products with all rows.
std::vector<IprSheet> measure_solvers(const HemicubeRequest& request, const RunOptions& options, const Tell& tell);

// What is a guess of the text, a line each.
std::vector<std::string> hemicube_guesses();
std::string hemicube_text(const Hemicube& result);
page::Json hemicube_json(const Hemicube& result);
std::string hemicube_csv(const Hemicube& result);
std::string hemicube_html(const Hemicube& result, const std::string& command);

}  // namespace plumb::cli
