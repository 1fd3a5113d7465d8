// plumb experiment probes: bakes at the sizes of IPR tables 5.1 and 5.2, beside the thesis' times; how time grows with probes and
// receivers; what truncation costs.
#include <fmt/format.h>
#include <malloc.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/host_math.h"
#include "core/parallel.h"
#include "gi/frame/settings.h"
#include "gi/probes/bake.h"
#include "gi/probes/sky_probe.h"
#include "io/file.h"
#include "tools/experiments/bake_sizes.h"
#include "tools/experiments/bare_rate.h"
#include "tools/experiments/experiments.h"
#include "tools/shared/announce.h"
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

struct Run {
    double seconds = 0, ray_seconds = 0, cluster_seconds = 0;
};

struct Row {
    Column column;
    int receivers = 0, probes = 0, lightmap = 0;
    std::uint64_t rays = 0;
    std::vector<Run> runs = {};                                            // by their seconds
    BareRate bare = {};
    std::size_t clusters = 0, peak_bytes = 0;
    std::vector<std::pair<int, probes::TruncationError>> truncation = {};  // by singular values kept

    const Run& median() const { return runs[runs.size() / 2]; }
    // From the shortest run to the longest, of the median.
    double spread() const { return (runs.back().seconds - runs.front().seconds) / median().seconds; }
};

struct ProbesOptions {
    SceneOptions scene;
    Common common;
    std::string output, only;
    int repeats = 1;
    double bare = 0;  // M rays
};

// The most memory that the process has held since forget_peak(): Linux' VmHWM. Memory that was freed but not given back counts.
std::size_t peak_bytes() {
    std::ifstream file("/proc/self/status");
    std::string name;
    std::size_t kilobytes = 0;
    while (file >> name)
        if (name == "VmHWM:" && file >> kilobytes) return kilobytes * 1024;
    return 0;
}
void forget_peak() {
    malloc_trim(0);
    std::ofstream("/proc/self/clear_refs") << "5";
}

Run run_once(const Scene& scene, const probes::BakeParams& params, const RunOptions& options, std::uint64_t bare_rays, Row& row) {
    Run run;
    forget_peak();
    const auto start = std::chrono::steady_clock::now();
    probes::BakeGraph graph(scene, params);
    graph::RunWith with;
    with.options = options;
    const std::vector<graph::NodeRun> runs = graph::run(graph.nodes(), with);
    run.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    run.ray_seconds = graph.seconds_of_rays(), run.cluster_seconds = runs.back().ms / 1000;
    const probes::Bake& b = graph.bake();
    row.receivers = b.receivers.count(), row.probes = probes::standing_probes(b.placement.probes);
    row.rays = b.counts().traced, row.clusters = b.clusters.clusters.size();
    row.peak_bytes = std::max(row.peak_bytes, peak_bytes());
    row.truncation.clear();
    for (const int kept : {4, 8, 16, 24, 32}) row.truncation.push_back({kept, truncation_error(b.clusters, kept)});
    if (bare_rays) row.bare = bare_rate(graph, bare_rays, 3, options);
    return run;
}

Row measure(const Scene& scene, probes::BakeParams params, const Column& column, int lightmap, const ProbesOptions& given) {
    Row row;
    row.column = column;
    params.lightmap_size = row.lightmap = lightmap;
    params.placement.count = column.probes;
    const RunOptions options = given.common.run_options();
    for (int i = 0; i < given.repeats; ++i)
        row.runs.push_back(run_once(scene, params, options, i == 0 ? std::uint64_t(given.bare * 1e6) : 0, row));
    std::sort(row.runs.begin(), row.runs.end(), [](const Run& a, const Run& b) { return a.seconds < b.seconds; });
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
        if (table == 0 || r.column.name[0] == table) points.push_back({x(r), r.median().seconds});
    return exponent(points);
}

std::string report(const std::string& scene, const std::vector<Row>& rows, int threads) {
    std::vector<std::vector<std::string>> table;
    for (const Row& r : rows)
        table.push_back({r.column.name, fmt::format("{}", r.lightmap), fmt::format("{}", r.receivers), fmt::format("{}", r.probes),
                         fmt::format("{:.1f}", double(r.rays) / 1e6), fmt::format("{:.2f}", r.median().seconds),
                         fmt::format("{:.1f} %", 100 * r.spread()), fmt::format("{:.2f}", r.median().ray_seconds),
                         fmt::format("{:.1f}", double(r.rays) / 1e6 / r.median().ray_seconds),
                         r.bare.rays ? fmt::format("{:.2f}", r.bare.share()) : "-",
                         fmt::format("{:.2f}", r.median().cluster_seconds), fmt::format("{}", r.clusters),
                         fmt::format("{:.0f}", double(r.peak_bytes) / 1e6), fmt::format("{}", r.column.receivers),
                         fmt::format("{:.0f}", 60 * r.column.minutes),
                         r.column.clusters ? fmt::format("{}", r.column.clusters) : "-"});
    std::string text = fmt::format("{}, {} threads\n\n", scene, threads);
    const Align right = Align::right;
    text += format_table({{"column"}, {"lightmap", right}, {"receivers", right}, {"probes", right}, {"M rays", right}, {"s", right},
                          {"spread", right}, {"s of rays", right}, {"M rays/s", right}, {"bare", right}, {"s of clusters", right}, {"clusters", right},
                          {"peak MB", right}, {"thesis: receivers", right}, {"s", right}, {"clusters", right}},
                         table);
    if (rows.size() > 5)
        text += fmt::format("\nseconds grow as probes^{:.2f} (P), receivers^{:.2f} (R), rays^{:.2f} (all)\n",
                        exponent_over(rows, 'P', [](const Row& r) { return double(r.probes); }),
                        exponent_over(rows, 'R', [](const Row& r) { return double(r.receivers); }),
                        exponent_over(rows, 0, [](const Row& r) { return double(r.rays); }));
    std::vector<std::vector<std::string>> errors;
    for (const Row& r : rows) {
        std::vector<std::string> line = {r.column.name};
        for (const auto& [kept, error] : r.truncation) line.push_back(fmt::format("{:.1e} {:.1e}", error.published, error.frobenius));
        errors.push_back(line);
    }
    text += "\ntruncation after so many singular values: as printed, and as a norm\n\n";
    return text + format_table({{"column"}, {"4", right}, {"8", right}, {"16", right}, {"24", right}, {"32", right}}, errors);
}

int probes_experiment(const ProbesOptions& given) {
    const RunOptions options = given.common.run_options();
    SceneOptions as_published = given.scene;
    const std::vector<std::string> thesis = {"probes.overlaps=10", "probes.receiver_rays=512", "probes.relight_rays=512",
                                             "probes.degree=7", "probes.singular_values=32", "probes.threshold=0.005",
                                             "probes.gather=interpolated"};
    as_published.sets.insert(as_published.sets.begin(), thesis.begin(), thesis.end());
    const Scene scene = load(as_published);
    const probes::BakeParams params = settings_of(scene, as_published).probes;
    // Of one core: 0.6 ms a receiver.
    double receivers = 0;
    for (const Column& column : columns)
        if (given.only.empty() || given.only == column.name) receivers += column.receivers;
    announce(fmt::format("experiment probes: bakes of {:.0f} receivers together, {} of each", receivers, given.repeats), 6e-4 * receivers * given.repeats, options);
    std::map<int, int> lightmaps;  // by the thesis' receivers
    std::vector<Row> rows;
    for (const Column& column : columns) {
        if (!given.only.empty() && given.only != column.name) continue;
        if (!lightmaps.count(column.receivers))
            lightmaps[column.receivers] = lightmap_for(scene, params, column.receivers, column.lightmap, options);
        const int lightmap = lightmaps[column.receivers];
        const int receivers = receivers_at(scene, params, lightmap, options);
        if (receivers < column.receivers * 1.25)
            rows.push_back(measure(scene, params, column, lightmap, given));
        else
            fmt::print(stderr, "{}: left out: the smallest lightmap with room for the scene's charts has {} receivers\n", column.name,
                       receivers);
    }
    if (lightmaps.empty()) throw InputError("--only " + io::printable(given.only) + ": expected P0 to P4 or R0 to R4");
    if (rows.empty()) throw InputError(given.scene.file + ": no lightmap of these sizes has room for its charts");
    const std::string text = report(io::stem_of(scene.name), rows, thread_count(options.threads));
    if (!given.output.empty()) io::write_text(given.output, text);
    if (given.common.json) {
        Json all = Json::array();
        for (const Row& r : rows)
            all.push_back({{"column", r.column.name}, {"lightmap", r.lightmap}, {"receivers", r.receivers}, {"probes", r.probes},
                           {"rays", r.rays}, {"seconds", r.median().seconds}, {"spread", r.spread()},
                           {"seconds_of_rays", r.median().ray_seconds}, {"bare_rays", r.bare.rays},
                           {"bare_share", r.bare.rays ? Json(r.bare.share()) : Json()},
                           {"seconds_of_clusters", r.median().cluster_seconds}, {"clusters", r.clusters}, {"peak_bytes", r.peak_bytes}});
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
    command->add_option("--repeat", given->repeats, "bakes of each size: their median and spread")->check(CLI::Range(1, 100));
    command->add_option("--bare", given->bare, "of each size, give so many million of its rays to the ray query alone")
        ->check(number_within(0, 20))
        ->type_name("M");
    command->add_option("--set", given->scene.sets, "probes.key=value in place of the thesis'; may be repeated")
        ->allow_extra_args(false)
        ->type_name("T.K=V");
    add_common(*command, given->common);
    command->footer("Nothing is kept, and no file but the tables written. The lightmap is as large as gives as many receivers as the\nthesis had. s is the median, spread the longest bake less the shortest. bare: time of the ray query alone over\nthat of the bake's rays. Times mean something on an idle machine only.");
    command->callback([given, &action] { action = [=] { return probes_experiment(*given); }; });
}

}  // namespace plumb::cli
