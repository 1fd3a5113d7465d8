// plumb experiment hemicube: the benchmark (HEM 5.8), tests 1 and 2, and the comparisons 5.8.1 to 5.8.3.
#include <fmt/format.h>

#include <cmath>

#include "core/host_math.h"
#include "gi/radiosity/published_pass.h"
#include "tools/experiments/hemicube_world.h"

namespace plumb::cli {

namespace {

using page::Chart;
using page::ChartLine;

constexpr double ticks = 1e7;            // a second in the thesis' unit, 100 ns
constexpr int published_blocks = 16, published_block = 4;  // elements that the published way is timed on

// One row of the benchmark.
struct Run {
    std::string name;
    int vertices = 0, triangles = 0, size = 0, passes = 0;
    double visibility = 0, sums = 0;                      // s: rows; all passes
    double published_draw = 0, published_sum = 0;         // s, of one element and pass
    std::size_t bytes = 0;                                // of the rows
    double left = 0;                                      // of the passes, against converged ones
    IprErrors errors;
    Buffer<glm::vec4> irradiance;                         // converged

    double published() const { return vertices * double(passes) * (published_draw + published_sum); }
    double total() const { return visibility + sums; }
};

// Drawn and summed as published, of elements spread over all.
void time_published(const Box& box, const radiosity::RowParams& row, const Buffer<glm::vec4>& radiosity, const RunOptions& options, Run& run) {
    radiosity::PublishedPass pass;
    pass.row = row;
    const int n = box.elements.count(), count = std::min(published_block, n);
    double draw = 0, sum = 0;
    Buffer<glm::vec4> h;
    for (int k = 0; k < published_blocks; ++k) {
        const int first = int(std::int64_t(n - count) * k / (published_blocks - 1));
        const radiosity::PassTimes t = radiosity::published_irradiance(box.elements, pass, radiosity, first, count, options, h);
        draw += t.draw_seconds, sum += t.sum_seconds;
    }
    run.published_draw = draw / (published_blocks * count), run.published_sum = sum / (published_blocks * count);
}

Run measure(const Box& box, const ElementTruth& truth, int size, int passes, const HemicubeRequest& request, const RunOptions& options) {
    Run run;
    const radiosity::Elements& e = box.elements;
    run.vertices = e.count(), run.triangles = int(e.geometry.triangles.size()), run.size = size, run.passes = passes;
    radiosity::RowParams row;
    row.size = size;
    radiosity::FormFactors factors;
    run.visibility = timed(request.repeats, [&] { factors = radiosity::form_factors(e, row, options); });
    run.bytes = factors.bytes();
    const RowTransport rows(factors, e);
    radiosity::Solution some;
    run.sums = timed(request.repeats, [&] { some = passes_of(e, rows, passes, options); });
    const Buffer<glm::vec4> whole = radiosity::floats_of(converged(e, rows, options));
    run.left = mean_difference(radiosity::floats_of(some), whole, e.area);
    run.irradiance = rows.irradiance(whole, options);
    run.errors = errors_of(run.irradiance, truth);
    time_published(box, row, whole, options, run);
    return run;
}

void add_heads(IprSheet& sheet) {
    sheet.heads.insert(sheet.heads.end(), {{"visibility s", 4}, {"passes s", 4}, {"both s", 4}, {"a vertex: 100 ns", 0}, {"rows MB", 2},
                                           {"published way: draw ms", 3}, {"sum ms", 3}, {"sum's share %", 1}, {"all s", 2}, {"times ours", 1},
                                           {"passes' share, ours %", 1}, {"passes against converged: mean %", 3}});
    add_error_heads(sheet.heads, "truth");
}

void add_run(IprSheet& sheet, const Run& r, const std::vector<double>& first) {
    IprSheetRow row{r.name, fmt::format("hemicube {}, {} passes", r.size, r.passes), {}, {}};
    for (const double x : first) row.values.push_back(x);
    const double published = r.published_draw + r.published_sum;
    row.values.insert(row.values.end(), {r.visibility, r.sums, r.total(), ticks * r.total() / r.vertices, 1e-6 * double(r.bytes), 1e3 * r.published_draw,
                                         1e3 * r.published_sum, 100 * r.published_sum / published, r.published(), r.published() / r.total(),
                                         100 * r.sums / r.total(), 100 * r.left});
    add_error_values(row.values, r.errors);
    sheet.rows.push_back(std::move(row));
}

std::vector<double> each(const std::vector<Run>& runs, const std::function<double(const Run&)>& value) {
    std::vector<double> values;
    for (const Run& r : runs) values.push_back(value(r));
    return values;
}
ChartLine line(const std::string& name, const std::vector<Run>& runs, const std::function<double(const Run&)>& x, const std::function<double(const Run&)>& y) {
    ChartLine l{name, {}};
    for (const Run& r : runs) l.points.push_back({x(r), y(r), {{"row", r.name}}});
    return l;
}

double vertices_of(const Run& r) { return r.vertices; }
double size_of(const Run& r) { return r.size; }
double visibility_ticks(const Run& r) { return ticks * r.visibility / r.vertices; }
double sum_ticks(const Run& r) { return ticks * r.sums / r.vertices; }
double published_ticks(const Run& r) { return ticks * r.published() / r.vertices; }

// Figures 5.5 and 5.6.
Chart times_chart(const std::string& title, const std::string& x_name, const std::vector<Run>& runs, double (*x)(const Run&)) {
    return {title, x_name, "a vertex, 100 ns", true, true,
            {line("visibility, once", runs, x, visibility_ticks), line("all passes", runs, x, sum_ticks),
             line("as published: drawn and summed in each pass", runs, x, published_ticks)}};
}
// Figure 5.7.
Chart shares_chart(const std::vector<Run>& runs) {
    return {"figure 5.7: share of the sums", "hemicube, texels", "%", true, false,
            {line("as published: sums of texels", runs, size_of, [](const Run& r) { return 100 * r.published_sum / (r.published_draw + r.published_sum); }),
             line("ours: all passes", runs, size_of, [](const Run& r) { return 100 * r.sums / r.total(); })}};
}
Chart errors_chart(const std::string& x_name, const std::vector<Run>& runs, double (*x)(const Run&)) {
    return {"error of irradiance", x_name, "% of the mean", true, true,
            {line("against path tracing, mean |error|", runs, x, [](const Run& r) { return 100 * r.errors.mean; }),
             line("the same, rms without its noise", runs, x, [](const Run& r) { return 100 * r.errors.rms; }),
             line("the passes against converged ones", runs, x, [](const Run& r) { return 100 * r.left; })}};
}

}  // namespace

double fitted_exponent(const std::vector<double>& x, const std::vector<double>& y) {
    double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        const double a = host::log(x[i]), b = host::log(y[i]);
        n += 1, sx += a, sy += b, sxx += a * a, sxy += a * b;
    }
    const double spread = n * sxx - sx * sx;
    return spread > 1e-9 ? (n * sxy - sx * sy) / spread : 0;
}

IprSheet measure_complexity(const HemicubeRequest& request, const RunOptions& options, const Tell& tell) {
    IprSheet sheet{"test 1", "model complexity (HEM 5.8, 5.8.1, figure 5.5)", "the box, an element a vertex of its file; hemicubes of 64, 10 passes", {}, {}, {}, {}};
    sheet.heads = {{"vertices"}, {"triangles"}};
    add_heads(sheet);
    std::vector<Run> runs;
    for (const BenchmarkMesh& mesh : benchmark_meshes) {
        if (request.quick && mesh.vertices > 3000) continue;
        tell(fmt::format("test 1: {} vertices", mesh.vertices));
        const Box box = benchmark_box(mesh.triangles, false, options);
        runs.push_back(measure(box, trace_elements(box, request, options), request.quick ? 16 : 64, mesh.passes, request, options));
        runs.back().name = fmt::format("factor {}", mesh.factor);
        add_run(sheet, runs.back(), {double(runs.back().vertices), double(runs.back().triangles)});
    }
    const std::vector<double> v = each(runs, vertices_of), t = each(runs, [](const Run& r) { return r.triangles; });
    sheet.lines = {
        fmt::format("Grows as: visibility of a vertex triangles^{:.2f}, all visibility vertices^{:.2f}, passes vertices^{:.2f}, rows' bytes vertices^{:.2f}; "
                    "as published, a vertex and pass: drawing triangles^{:.2f}, sums triangles^{:.2f}.",
                    fitted_exponent(t, each(runs, visibility_ticks)), fitted_exponent(v, each(runs, [](const Run& r) { return r.visibility; })),
                    fitted_exponent(v, each(runs, [](const Run& r) { return r.sums; })), fitted_exponent(v, each(runs, [](const Run& r) { return double(r.bytes); })),
                    fitted_exponent(t, each(runs, [](const Run& r) { return r.published_draw; })), fitted_exponent(t, each(runs, [](const Run& r) { return r.published_sum; }))),
        "Thesis (5.8.1): model complexity is not the determining factor for a single vertex' time; its figure has no numbers that the text gives."};
    sheet.charts = {times_chart("figure 5.5: time of a vertex", "vertices", runs, vertices_of), errors_chart("vertices", runs, vertices_of)};
    return sheet;
}

IprSheet measure_sizes(const HemicubeRequest& request, const RunOptions& options, const Tell& tell) {
    IprSheet sheet{"test 2", "hemicube size (HEM 5.8, 5.8.2 and 5.8.3, figures 5.6 and 5.7)", "the box of 774 vertices and 1,200 triangles, 5 passes", {}, {}, {}, {}};
    sheet.heads = {{"texels"}};
    add_heads(sheet);
    sheet.heads.push_back({"against the largest: mean %", 3});
    const Box box = benchmark_box(benchmark_meshes[0].triangles, false, options);
    tell("test 2: truth");
    const ElementTruth truth = trace_elements(box, request, options);
    std::vector<Run> runs;
    for (const int size : benchmark_sizes) {
        if (request.quick && size > 64) continue;
        tell(fmt::format("test 2: hemicubes of {}", size));
        runs.push_back(measure(box, truth, size, 5, request, options));
        runs.back().name = fmt::format("{}", size);
        add_run(sheet, runs.back(), {3.0 * size * size});
    }
    for (std::size_t i = 0; i < runs.size(); ++i)
        sheet.rows[i].values.push_back(100 * mean_difference(runs[i].irradiance, runs.back().irradiance, box.elements.area));
    const std::vector<double> sizes = each(runs, size_of);
    sheet.lines = {
        fmt::format("Grows as: visibility size^{:.2f}, passes size^{:.2f}; as published, a vertex and pass: drawing size^{:.2f}, sums size^{:.2f}. Squared is 2.",
                    fitted_exponent(sizes, each(runs, visibility_ticks)), fitted_exponent(sizes, each(runs, sum_ticks)),
                    fitted_exponent(sizes, each(runs, [](const Run& r) { return r.published_draw; })), fitted_exponent(sizes, each(runs, [](const Run& r) { return r.published_sum; }))),
        "Thesis (5.8.2): pixels grow in a squared proportion; each larger hemicube takes almost a whole order of magnitude longer.",
        "Thesis (5.8.3, figure 5.7): close to equal workload, more than half of it sums and decoding on the CPU, the more so the larger the hemicube."};
    sheet.charts = {times_chart("figure 5.6: time of a vertex", "hemicube, texels", runs, size_of), shares_chart(runs), errors_chart("hemicube, texels", runs, size_of)};
    return sheet;
}

}  // namespace plumb::cli
