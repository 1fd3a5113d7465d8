// The rasterizer's speed: against lavapipe in the same run, against triangles, pixels and threads; its memory.
#include <CLI/CLI.hpp>
#include <exception>
#include <iostream>

#include "core/error.h"
#include "tools/bench_raster/experiments.h"
#include "tools/bench_raster/hemicubes.h"

int main(int argc, char** argv) {
    using namespace plumb;
    bench::Options options;
    std::string against, isa = "auto", csv;
    CLI::App app(
        "Measures the rasterizer: three RGBA16F targets (position, normal, albedo) and depth of generated scenes",
        "tools/bench raster");
    app.add_option("--against", against, "also draw everything with this peer: lavapipe")
        ->check(CLI::IsMember({"lavapipe"}));
    app.add_option("--runs", options.runs, "runs of each side, in turns (7)")->check(CLI::Range(1, 1000));
    app.add_option("--threads", options.threads, "of both sides; 0: all processors (0)")->check(CLI::Range(0, 1024));
    app.add_option("--isa", isa, "auto, scalar, sse, avx2 or avx512 (auto)");
    app.add_option("--scenes", options.scenes,
                   "generated scenes (atrium,city); the first is drawn at many sizes, the "
                   "last with many triangles")
        ->delimiter(',');
    app.add_option("--what", options.what, "compare,phases,threads,pixels,triangles,memory (all of these), hemicubes")
        ->delimiter(',')
        ->check(CLI::IsMember({"compare", "phases", "threads", "pixels", "triangles", "memory", "hemicubes"}));
    app.add_option("--csv", csv, "also write every measurement to this file");
    app.add_flag("--quick", options.quick, "one size a scene and short curves: to see that it runs");
    CLI11_PARSE(app, argc, argv);
    try {
        options.against_lavapipe = against == "lavapipe";
        options.isa = parse_isa(isa);
        if (options.wants("hemicubes")) bench::compare_hemicubes(options);
        std::erase(options.what, "hemicubes");
        if (options.what.empty()) return 0;
        const std::vector<bench::Row> rows = bench::run_experiments(options);
        if (!csv.empty()) bench::write_csv(csv, rows);
        return 0;
    } catch (const InputError& error) {
        std::cerr << "bench raster: " << error.what() << "\n";
        return 2;
    } catch (const std::exception& error) {
        std::cerr << "bench raster: " << error.what() << "\n";
        return 1;
    }
}
