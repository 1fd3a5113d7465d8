// What is measured, and how it is told.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/isa.h"
#include "tools/bench_raster/agreement.h"
#include "tools/bench_raster/load.h"
#include "tools/bench_raster/measure.h"

namespace plumb::bench {

struct Options {
    bool against_lavapipe = false;
    int runs = 7;
    int threads = 0;  // of both sides; 0: all processors
    Isa isa = best_isa();
    bool quick = false;  // one size a scene, and small curves
    std::vector<std::string> scenes{"atrium", "city"};
    std::vector<std::string> what{"compare", "phases", "threads", "triangles", "pixels", "memory"};

    RunOptions run_options() const;
    bool wants(const std::string& experiment) const;
};

// One scene at one size: a line of every table.
struct Row {
    std::string experiment, scene;
    std::size_t triangles = 0;
    glm::ivec2 size{0};
    int threads = 0;
    std::string isa;
    Times ours, theirs;    // theirs.ms is empty without a peer
    double device_ms = 0;  // what the peer's own clock said of its last frame
    std::optional<Agreement> agreement;

    double ratio() const { return theirs.median() / ours.median(); }
    double cpu_ratio() const { return theirs.cpu_median() / ours.cpu_median(); }
};

// All that the options ask for, told on standard output as Markdown while it is measured. Throws std::runtime_error
// where both sides draw different pictures.
std::vector<Row> run_experiments(const Options& options);

void write_csv(const std::string& file, const std::vector<Row>& rows);

}  // namespace plumb::bench
