// plumb experiment probes: bakes at the sizes of IPR tables 5.1 and 5.2, beside the thesis' times; how time grows with probes and
// receivers; what truncation costs.
#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/host_math.h"
#include "core/parallel.h"
#include "gi/frame/settings.h"
#include "gi/probes/bake.h"
#include "io/file.h"
#include "tools/experiments/experiments.h"
#include "tools/shared/command.h"
#include "tools/shared/reports.h"
#include "tools/shared/scene_command.h"
#include "tools/shared/table.h"

namespace plumb::cli {

namespace {

// A column of a table of the thesis: two cores of a Core i5-3210M at 2.5 GHz.
struct Column {
    const char* name;
    int lightmap, probes;
    int receivers;    // of the thesis
    double minutes;   // of its precomputation
    int clusters;     // of the thesis; 0: not printed
};
constexpr Column columns[] = {
    {"P0", 512, 1, 65011, 3.84, 0},   {"P1", 512, 3, 65011, 5.70, 0},     {"P2", 512, 11, 65011, 25.14, 0},
    {"P3", 512, 30, 65011, 36.12, 0}, {"P4", 512, 78, 65011, 54.31, 0},   {"R0", 64, 7, 712, 0.09, 2},
    {"R1", 128, 7, 3369, 0.45, 4},    {"R2", 256, 7, 15608, 2.06, 36},    {"R3", 512, 7, 67662, 8.75, 103},
    {"R4", 1024, 7, 282403, 37.8, 428},
};

struct Row {
    Column column;
    int receivers = 0, probes = 0, lightmap = 0;
    std::uint64_t rays = 0;
    double seconds = 0, ray_seconds = 0, cluster_seconds = 0;
    std::size_t clusters = 0, peak_bytes = 0;
    std::vector<std::pair<int, probes::TruncationError>> truncation = {};  // by singular values kept
};

struct ProbesOptions {
    SceneOptions scene;
    Common common;
    std::string output, only;
};

std::size_t peak_bytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return std::size_t(usage.ru_maxrss) * 1024;
}

// The size whose lightmap has about as many receivers: charts do not fill it alike in every scene.
int lightmap_for(const Scene& scene, probes::BakeParams params, const Column& column, const RunOptions& options) {
    int size = column.lightmap;
    for (int step = 0; step < 6; ++step) {
        params.lightmap_size = size, params.test_rays = 0;
        probes::BakeGraph graph(scene, params);
        graph::RunWith with;
        with.options = options;
        graph::run({graph.nodes()[0], graph.nodes()[1]}, with);
        const double ratio = double(column.receivers) / graph.bake().receivers.count();
        const int next = std::clamp(int(size * std::sqrt(ratio) + 0.5), 8, 16384);
        if (std::abs(ratio - 1) < 0.02 || next == size) break;
        size = next;
    }
    return size;
}

Row measure(const Scene& scene, probes::BakeParams params, const Column& column, const RunOptions& options) {
    Row row;
    row.column = column;
    params.lightmap_size = row.lightmap = lightmap_for(scene, params, column, options);
    params.placement.count = column.probes;
    const auto start = std::chrono::steady_clock::now();
    probes::BakeGraph graph(scene, params);
    graph::RunWith with;
    with.options = options;
    const std::vector<graph::NodeRun> runs = graph::run(graph.nodes(), with);
    row.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const probes::Bake& b = graph.bake();
    row.receivers = b.receivers.count(), row.probes = int(b.placement.probes.size());
    row.rays = b.counts().traced, row.ray_seconds = graph.seconds_of_rays();
    row.cluster_seconds = runs.back().ms / 1000;
    row.clusters = b.clusters.clusters.size(), row.peak_bytes = peak_bytes();
    for (const int kept : {4, 8, 16, 24, 32}) row.truncation.push_back({kept, truncation_error(b.clusters, kept)});
    return row;
}

// The exponent e of seconds ~ x^e, by least squares of logarithms.
double exponent(const std::vector<std::pair<double, double>>& points) {
    double sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (const auto& [x, y] : points) {
        const double lx = host::log(x), ly = host::log(y);
        sx += lx, sy += ly, sxx += lx * lx, sxy += lx * ly;
    }
    const double n = double(points.size()), d = n * sxx - sx * sx;
    return points.size() > 1 && d != 0 ? (n * sxy - sx * sy) / d : std::nan("");
}

double exponent_over(const std::vector<Row>& rows, char table, double (*x)(const Row&)) {
    std::vector<std::pair<double, double>> points;
    for (const Row& r : rows)
        if (table == 0 || r.column.name[0] == table) points.push_back({x(r), r.seconds});
    return exponent(points);
}

std::string report(const std::string& scene, const std::vector<Row>& rows, int threads) {
    std::vector<std::vector<std::string>> table;
    for (const Row& r : rows)
        table.push_back({r.column.name, fmt::format("{}", r.lightmap), fmt::format("{}", r.receivers), fmt::format("{}", r.probes),
                         fmt::format("{:.1f}", double(r.rays) / 1e6), fmt::format("{:.2f}", r.seconds),
                         fmt::format("{:.2f}", r.ray_seconds), fmt::format("{:.1f}", double(r.rays) / 1e6 / r.ray_seconds),
                         fmt::format("{:.2f}", r.cluster_seconds), fmt::format("{}", r.clusters),
                         fmt::format("{:.0f}", double(r.peak_bytes) / 1e6), fmt::format("{}", r.column.receivers),
                         fmt::format("{:.0f}", 60 * r.column.minutes),
                         r.column.clusters ? fmt::format("{}", r.column.clusters) : "-"});
    std::string text = fmt::format("{}, {} threads\n\n", scene, threads);
    const Align right = Align::right;
    text += format_table({{"column"}, {"lightmap", right}, {"receivers", right}, {"probes", right}, {"M rays", right}, {"s", right},
                          {"s of rays", right}, {"M rays/s", right}, {"s of clusters", right}, {"clusters", right},
                          {"peak MB", right}, {"thesis: receivers", right}, {"s", right}, {"clusters", right}},
                         table);
    text += fmt::format("\nseconds grow as probes^{:.2f} (P), receivers^{:.2f} (R), rays^{:.2f} (all)\n\n",
                        exponent_over(rows, 'P', [](const Row& r) { return double(r.probes); }),
                        exponent_over(rows, 'R', [](const Row& r) { return double(r.receivers); }),
                        exponent_over(rows, 0, [](const Row& r) { return double(r.rays); }));
    std::vector<std::vector<std::string>> errors;
    for (const Row& r : rows) {
        std::vector<std::string> line = {r.column.name};
        for (const auto& [kept, error] : r.truncation) line.push_back(fmt::format("{:.1e} {:.1e}", error.published, error.frobenius));
        errors.push_back(line);
    }
    text += "truncation after so many singular values: as printed, and as a norm\n\n";
    return text + format_table({{"column"}, {"4", right}, {"8", right}, {"16", right}, {"24", right}, {"32", right}}, errors);
}

int probes_experiment(const ProbesOptions& given) {
    const RunOptions options = given.common.run_options();
    const Scene scene = load(given.scene);
    const probes::BakeParams params = settings_of(scene, given.scene).probes;
    std::vector<Row> rows;
    for (const Column& column : columns)
        if (given.only.empty() || given.only == column.name) rows.push_back(measure(scene, params, column, options));
    if (rows.empty()) throw InputError("--only: expected P0 to P4 or R0 to R4");
    const std::string text = report(io::stem_of(scene.name), rows, thread_count(options.threads));
    if (!given.output.empty()) io::write_text(given.output, text);
    if (given.common.json) {
        Json all = Json::array();
        for (const Row& r : rows)
            all.push_back({{"column", r.column.name}, {"lightmap", r.lightmap}, {"receivers", r.receivers}, {"probes", r.probes},
                           {"rays", r.rays}, {"seconds", r.seconds}, {"seconds_of_rays", r.ray_seconds},
                           {"seconds_of_clusters", r.cluster_seconds}, {"clusters", r.clusters}, {"peak_bytes", r.peak_bytes}});
        std::fputs(json_text({{"version", 1}, {"rows", all}}).c_str(), stdout);
    } else {
        std::fputs(text.c_str(), stdout);
    }
    return success;
}

}  // namespace

void add_probes(CLI::App& experiment, Action& action) {
    auto given = std::make_shared<ProbesOptions>();
    CLI::App* command = experiment.add_subcommand("probes", "bakes at the sizes of IPR tables 5.1 and 5.2, beside the thesis");
    command->add_option("scene", given->scene.file, "the scene")->required()->type_name("SCENE");
    command->add_option("-o,--output", given->output, "the tables, as text")->check(some_word())->type_name("FILE");
    command->add_option("--only", given->only, "one column: P0 to P4, R0 to R4")->check(some_word())->type_name("C");
    command->add_option("--set", given->scene.sets, "probes.key=value in place of the scene file's; may be repeated")
        ->allow_extra_args(false)
        ->type_name("T.K=V");
    add_common(*command, given->common);
    command->footer("Nothing is kept, and no file but the tables written. The lightmap is as large as gives as many receivers as the\nthesis had. Times are of one run: repeat it on an idle machine.");
    command->callback([given, &action] { action = [=] { return probes_experiment(*given); }; });
}

}  // namespace plumb::cli
