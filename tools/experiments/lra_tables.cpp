// Tables 7.1 to 7.5 of LRA: lights and model at rest.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "tools/experiments/lra.h"

namespace plumb::cli {

namespace {

using page::Chart;
using page::ChartLine;
using page::Line;
using Rows = std::vector<LraCase>;
using Results = std::vector<std::optional<LraMeasured>>;
using Lights = std::vector<LraLight>;
constexpr LraLight direct = LraLight::direct, spot = LraLight::spot, point = LraLight::point;

// LRA, tables 7.1 to 7.5 as printed.
struct Printed {
    const char* name;
    double fps, ms;
};
constexpr Printed table_1[] = {{"None", 60.41, 16.60}, {"IS", 60.35, 16.71}, {"AO", 60.40, 16.61}, {"ID", 23.99, 42.28},
                               {"IS + AO", 59.93, 16.98}, {"IS + ID", 18.47, 54.89}, {"AO + ID", 22.63, 44.77}, {"IS + AO + ID", 18.08, 56.00}};
constexpr double shares[] = {0.001, 0.01, 0.1, 0.25, 0.5, 0.75, 1};
constexpr Printed table_2[] = {{"0.1 %", 60.68, 16.53}, {"1 %", 60.52, 16.54}, {"10 %", 60.49, 16.60}, {"25 %", 56.48, 18.19},
                               {"50 %", 32.63, 30.98}, {"75 %", 22.22, 45.44}, {"100 %", 18.10, 55.96}};
constexpr Printed table_3[] = {{"direct 1", 32.63, 30.98}, {"spot 1", 30.63, 33.17}, {"direct 2", 17.30, 58.47}, {"spot 2", 17.10, 59.35}};
constexpr Printed table_4[] = {{"1", 32.63, 30.98}, {"2", 17.30, 59.03}, {"3", 11.66, 86.85}, {"4", 8.85, 115.42}, {"5", 7.29, 144.49}};
constexpr glm::ivec2 sizes[] = {{480, 360}, {640, 480}, {800, 800}, {1280, 720}, {1920, 1080}};
constexpr Printed table_5[] = {{"480 x 360", 24.39, 26.10}, {"640 x 480", 24.15, 41.88}, {"800 x 800", 11.66, 86.85},
                               {"1280 x 720", 13.76, 76.92}, {"1920 x 1080", 8.14, 124.24}};

LraCase row_of(const Printed& p) {
    LraCase row;
    row.name = p.name, row.thesis_fps = p.fps, row.thesis_ms = p.ms;
    return row;
}

// In the order in which LRA 7.4 adds them, and on.
Lights lights_of(int n) {
    constexpr LraLight order[] = {direct, spot, spot, direct, spot};
    Lights all;
    for (int i = 0; i < n; ++i) all.push_back(order[i % 5]);
    return all;
}

std::string half(const LraWorld& world) {
    const glm::ivec2 size = world.size({});
    return fmt::format("half of the model, {} x {}", size.x, size.y);
}

IprSheet sheet_of(const std::string& id, const std::string& title, const std::string& notes, const Rows& rows, const Results& results) {
    IprSheet sheet{id, title, notes, {}, {}, {}, {}};
    sheet.heads = {{"ms, lights at rest", 1}, {"maps ms", 1}, {"ms of all", 1}, {"G-buffer ms", 1}, {"direct ms", 1}, {"IS ms", 1}, {"AO ms", 1}, {"ID ms", 1}, {"processor ms", 1},
                   {"thesis FPS", 2}, {"thesis ms", 2}, {"1000 / thesis FPS", 2}, {"triangles"}, {"that touch the frame"}, {"covered pixels"},
                   {"fragments"}, {"fragments that pass"}, {"overdraw", 2}, {"samples, millions", 2}, {"maps"}, {"map texels, millions", 2}};
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const LraCase& r = rows[i];
        IprSheetRow row{r.name, results[i] ? "" : "not run: no stage", {}, {}};
        const std::optional<double> period = r.thesis_fps ? std::optional(1000 / *r.thesis_fps) : std::nullopt;
        if (!results[i]) {
            row.values.resize(9);
            row.values.insert(row.values.end(), {r.thesis_fps, r.thesis_ms, period});
            row.values.resize(sheet.heads.size());
        } else {
            const LraMeasured& m = *results[i];
            const LraTimes& t = m.times;
            row.values = {t.still(), t.maps, t.all, t.camera, t.direct, t.mirrors, t.ao, t.gather, t.processor, r.thesis_fps, r.thesis_ms, period, double(m.triangles),
                          double(m.fragments.triangles), double(m.fragments.covered), double(m.fragments.drawn), double(m.fragments.passing),
                          m.fragments.overdraw(), 1e-6 * m.samples, double(m.maps), 1e-6 * m.texels};
        }
        sheet.rows.push_back(std::move(row));
    }
    return sheet;
}

// The rows' numbers that both a count and a time have.
struct Pairs {
    std::vector<double> x, ours, thesis;
};
template <class X>
Pairs pairs_of(const Rows& rows, const Results& results, X x, bool capped_too = false) {
    Pairs p;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        if (!results[i]) continue;
        if (rows[i].thesis_fps && (capped_too || *rows[i].thesis_fps < 59)) p.thesis.push_back(1000 / *rows[i].thesis_fps);
        else if (!capped_too && rows[i].thesis_fps) continue;
        p.x.push_back(x(rows[i], *results[i])), p.ours.push_back(results[i]->times.processor);
    }
    return p;
}
// The first rows, as many as have a time.
std::string fit_text(const std::string& whose, const std::string& unit, const std::vector<double>& x, const std::vector<double>& y) {
    const std::vector<double> first(x.begin(), x.begin() + std::ptrdiff_t(std::min(x.size(), y.size())));
    const std::optional<LraLine> line = fitted_line(first, y);
    if (!line) return fmt::format("{}: too few rows for a line.", whose);
    return fmt::format("{}: {:.3g} ms and {:.3g} ms for {}, off by at most {:.1f} %.", whose, line->fixed, line->each, unit, 100 * line->off);
}

// Which of several counts a line of times follows best.
struct Count {
    std::string name;
    const std::vector<double>& x;
};
std::string best_text(const std::vector<double>& y, const std::vector<Count>& counts) {
    const Count* best = nullptr;
    double off = 0;
    for (const Count& c : counts) {
        const std::optional<LraLine> line = fitted_line(c.x, y);
        if (line && (!best || line->off < off)) best = &c, off = line->off;
    }
    return best ? fmt::format("Of these counts LRA's times follow {} best, to {:.1f} %.", best->name, 100 * off) : "";
}

template <class Value>
ChartLine line_of(const std::string& name, const Rows& rows, const Results& results, Value value) {
    ChartLine line{name, {}};
    for (std::size_t i = 0; i < rows.size(); ++i)
        if (const std::optional<std::pair<double, double>> at = value(rows[i], results[i])) line.points.push_back({at->first, at->second, {{"row", rows[i].name}}});
    return line;
}
// Ours and the thesis' over x.
template <class X>
Chart chart_of(const std::string& title, const std::string& x_name, bool logarithmic, const Rows& rows, const Results& results, X x) {
    using At = std::optional<std::pair<double, double>>;
    const auto ours = [&](auto part) {
        return [=](const LraCase& r, const std::optional<LraMeasured>& m) { return m ? At({x(r), part(m->times)}) : At(); };
    };
    return {title, x_name, "ms", logarithmic, logarithmic,
            {line_of("ours, lights at rest", rows, results, ours([](const LraTimes& t) { return t.still(); })),
             line_of("ours, all drawn anew, processor time", rows, results, ours([](const LraTimes& t) { return t.processor; })),
             line_of("LRA: 1000 / FPS", rows, results, [=](const LraCase& r, const std::optional<LraMeasured>&) { return r.thesis_fps ? At({x(r), 1000 / *r.thesis_fps}) : At(); })}};
}

double passing(const LraCase&, const LraMeasured& m) { return 1e-6 * double(m.fragments.passing); }
double covered(const LraCase&, const LraMeasured& m) { return 1e-6 * double(m.fragments.covered); }

IprSheet table_7_1(LraWorld& world, const RunOptions& options, const LraTell& tell) {
    const std::vector<std::vector<std::string>> combined = {{}, {"IS"}, {"AO"}, {"ID"}, {"IS", "AO"}, {"IS", "ID"}, {"AO", "ID"}, {"IS", "AO", "ID"}};
    Rows rows;
    for (std::size_t i = 0; i < combined.size(); ++i) rows.push_back(row_of(table_1[i])), rows.back().algorithms = combined[i];
    const Results results = measure_cases(world, rows, options, tell);
    IprSheet sheet = sheet_of("table 7.1", "algorithms alone and combined", fmt::format("the whole model, one directional light, {} x {}; a row whose algorithm has no stage is not run", world.size({}).x, world.size({}).y), rows, results);
    const auto more = [&](std::size_t without, std::size_t with) { return results[with]->times.processor - results[without]->times.processor; };
    sheet.lines = {
        "The thesis' None, IS, AO and IS + AO all take 16.6 to 17.0 ms: the 60 frames a second of a display, not what they cost. Only beside ID it can be read: AO 44.77 - 42.28 = 2.5 ms, "
        "IS 54.89 - 42.28 = 12.6 ms: neither is free.",
        fmt::format("Ours, processor time: AO {:.0f} ms alone and {:.0f} beside ID, ID {:.0f} alone and {:.0f} beside AO.", more(0, 2), more(3, 6), more(0, 3), more(2, 6))};
    for (const std::size_t i : {std::size_t(0), std::size_t(6), std::size_t(7)})
        if (results[i]) sheet.rows[i].pictures.push_back({"", results[i]->display});
    return sheet;
}

IprSheet table_7_2(LraWorld& world, const RunOptions& options, const LraTell& tell) {
    Rows rows;
    for (std::size_t i = 0; i < std::size(shares); ++i) rows.push_back(row_of(table_2[i])), rows.back().share = shares[i];
    const Results results = measure_cases(world, rows, options, tell);
    IprSheet sheet = sheet_of("table 7.2", "share of the model that is drawn", fmt::format("one directional light, {} x {}, a map of {} x {}; of each mesh the first triangles, in file order", world.size({}).x, world.size({}).y, world.request().map, world.request().map), rows, results);
    const auto share = [](const LraCase& r, const LraMeasured&) { return 100 * r.share; };
    const Pairs by_share = pairs_of(rows, results, share), by_passing = pairs_of(rows, results, passing), by_covered = pairs_of(rows, results, covered);
    sheet.lines = {
        "The thesis sees a huge slope from 10 to 50 % and a smaller one after it. Its rows up to 10 % are the display's 60 frames a second; the curve is one of frames a second, 1 / t. Of its times the "
        "rows from 25 % on lie on a line:",
        fit_text("LRA, over the share", "1 %", by_share.x, by_share.thesis),
        fit_text("LRA, over our millions of fragments that pass", "a million", by_passing.x, by_passing.thesis),
        fit_text("LRA, over our millions of covered pixels", "a million", by_covered.x, by_covered.thesis),
        best_text(by_share.thesis, {{"the share", by_share.x}, {"fragments that pass", by_passing.x}, {"covered pixels", by_covered.x}}),
        fit_text("Ours, processor time over millions of covered pixels, all rows", "a million", pairs_of(rows, results, covered, true).x, pairs_of(rows, results, covered, true).ours),
        "It draws the model again to shade it (chapter 9), so that each fragment that passes the depth test gathers, hidden later or not: \"overdraw\" is how many a covered pixel has. Ours shades covered pixels once."};
    sheet.charts = {chart_of("table 7.2", "share of the model, %", true, rows, results, [](const LraCase& r) { return 100 * r.share; })};
    return sheet;
}

IprSheet table_7_3(LraWorld& world, const RunOptions& options, const LraTell& tell) {
    const Lights lights[] = {{direct}, {spot}, {direct, direct}, {spot, spot}};
    Rows rows;
    for (std::size_t i = 0; i < std::size(lights); ++i) rows.push_back(row_of(table_3[i])), rows.back().lights = lights[i], rows.back().share = 0.5;
    rows.push_back({}), rows.back().name = "point 1", rows.back().lights = {point}, rows.back().share = 0.5;
    const Results results = measure_cases(world, rows, options, tell);
    IprSheet sheet = sheet_of("table 7.3", "type of lights", half(world), rows, results);
    const auto more = [&](std::size_t a, std::size_t b) { return results[a] && results[b] ? 100 * (results[b]->times.processor / results[a]->times.processor - 1) : 0; };
    sheet.lines = {fmt::format("A spot costs more than a directional light by {:+.1f} % (one) and {:+.1f} % (two) of processor time; LRA {:+.1f} % and {:+.1f} %.", more(0, 1), more(2, 3),
                               100 * (32.63 / 30.63 - 1), 100 * (17.30 / 17.10 - 1)),
                   "A point light, which the thesis' conclusion wishes for, has a map a face of a cube; those that cannot see the model are not drawn."};
    return sheet;
}

IprSheet table_7_4(LraWorld& world, const RunOptions& options, const LraTell& tell) {
    Rows rows;
    for (const int n : {1, 2, 3, 4, 5, 8, 16, 32}) {
        if (n > 5 && n > world.request().most_lights) continue;
        if (n <= 5) rows.push_back(row_of(table_4[n - 1]));
        else rows.push_back({}), rows.back().name = fmt::format("{}", n);
        rows.back().lights = lights_of(n), rows.back().share = 0.5;
    }
    const Results results = measure_cases(world, rows, options, tell);
    IprSheet sheet = sheet_of("table 7.4", "number of lights", half(world) + "; directional, spot, spot, directional, spot, and so on", rows, results);
    std::vector<double> n, ours, processor, thesis;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        n.push_back(double(rows[i].lights.size())), ours.push_back(results[i]->times.still()), processor.push_back(results[i]->times.processor);
        if (rows[i].thesis_fps) thesis.push_back(1000 / *rows[i].thesis_fps);
    }
    sheet.lines = {
        "The thesis is surprised that each further light costs less. In frames a second it does; a frame's time is a fixed part and one of each light, a line:",
        fit_text("LRA", "a light", n, thesis), fit_text("Ours, all drawn anew, processor time", "a light", n, processor), fit_text("Ours, maps kept, by the clock", "a light", n, ours),
        "From one light to two frames a second fall by nearly a half, from four to five by a fifth, whatever is fixed: n a / (n + 1) a."};
    sheet.charts = {chart_of("table 7.4", "lights", true, rows, results, [](const LraCase& r) { return double(r.lights.size()); })};
    return sheet;
}

IprSheet table_7_5(LraWorld& world, const RunOptions& options, const LraTell& tell) {
    Rows rows;
    for (std::size_t i = 0; i < std::size(sizes); ++i)
        rows.push_back(row_of(table_5[i])), rows.back().size = sizes[i], rows.back().share = 0.5, rows.back().lights = lights_of(3);
    const Results results = measure_cases(world, rows, options, tell);
    IprSheet sheet = sheet_of("table 7.5", "resolution", fmt::format("half of the model, three lights; frames' sides divided by {}", world.request().divide), rows, results);
    std::vector<double> pixels, shown, forward, ours, thesis;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        pixels.push_back(1e-6 * rows[i].size.x * rows[i].size.y);
        shown.push_back(1e-6 * double(results[i]->fragments.covered)), forward.push_back(1e-6 * double(results[i]->fragments.passing));
        ours.push_back(results[i]->times.processor), thesis.push_back(1000 / *rows[i].thesis_fps);
        sheet.rows[i].settings = fmt::format("aspect {:.2f}, {:.1f} % covered", double(rows[i].size.x) / rows[i].size.y,
                                             100 * double(results[i]->fragments.covered) * world.request().divide * world.request().divide / (rows[i].size.x * double(rows[i].size.y)));
    }
    const LraMeasured &square = *results[2], &wide = *results[3];
    sheet.lines = {
        fmt::format("The dip at 800 x 800 (85.8 ms against 72.7 at 1280 x 720, which has more pixels) is its aspect ratio, as the thesis suspects: the angle of view is vertical, so that what the model covers "
                    "grows with the square of the height alone; a wider frame shows more background. Counted here: {} pixels of the model at 800 x 800, {} at 1280 x 720 (divided as above), {:.2f} as many; "
                    "(720/800)^2 = 0.81; LRA's times 72.7 / 85.8 = 0.85.",
                    square.fragments.covered, wide.fragments.covered, double(wide.fragments.covered) / double(square.fragments.covered)),
        fit_text("LRA, over millions of pixels", "a million", pixels, thesis), fit_text("LRA, over our millions of covered pixels", "a million", shown, thesis),
        fit_text("LRA, over our millions of fragments that pass", "a million", forward, thesis), fit_text("Ours, processor time over millions of pixels", "a million", pixels, ours),
        fit_text("Ours, processor time over millions of covered pixels", "a million", shown, ours),
        "LRA prints 26.10 ms beside 24.39 frames a second at 480 x 360, which are 41.0 ms; and 24.15 frames a second at 640 x 480, with 1.8 times the pixels. One of them is a slip; lines use frames a second."};
    using At = std::optional<std::pair<double, double>>;
    Chart chart = chart_of("table 7.5", "pixels of the model, millions", false, rows, results, [](const LraCase&) { return 0.0; });
    chart.lines.clear();
    chart.lines.push_back(line_of("ours, lights at rest", rows, results, [](const LraCase& r, const std::optional<LraMeasured>& m) { return At({covered(r, *m), m->times.still()}); }));
    chart.lines.push_back(line_of("ours, all drawn anew, processor time", rows, results, [](const LraCase& r, const std::optional<LraMeasured>& m) { return At({covered(r, *m), m->times.processor}); }));
    chart.lines.push_back(line_of("LRA: 1000 / FPS", rows, results, [](const LraCase& r, const std::optional<LraMeasured>& m) { return At({covered(r, *m), 1000 / *r.thesis_fps}); }));
    for (ChartLine& line : chart.lines) line.line = Line::points;
    sheet.charts = {chart};
    return sheet;
}

// What was counted, and what it explains, as a table of its own: one with all columns is wider than a page.
IprSheet take_counts(IprSheet& sheet) {
    constexpr std::ptrdiff_t times = 12;
    IprSheet counts{sheet.id + " counts", "what was counted", sheet.notes, {sheet.heads.begin() + times, sheet.heads.end()}, {}, std::move(sheet.lines), {}};
    for (IprSheetRow& row : sheet.rows) {
        counts.rows.push_back({row.name, row.settings, {row.values.begin() + times, row.values.end()}, {}});
        row.values.resize(std::size_t(times));
    }
    sheet.heads.resize(std::size_t(times)), sheet.lines.clear();
    return counts;
}

}  // namespace

std::vector<IprSheet> lra_still_tables(LraWorld& world, const RunOptions& options, const LraTell& tell) {
    const struct {
        const char* part;
        IprSheet (*measure)(LraWorld&, const RunOptions&, const LraTell&);
    } tables[] = {{"algorithms", table_7_1}, {"share", table_7_2}, {"types", table_7_3}, {"lights", table_7_4}, {"sizes", table_7_5}};
    std::vector<IprSheet> sheets;
    for (const auto& [part, measure] : tables)
        if (world.request().wants(part)) {
            IprSheet sheet = measure(world, options, tell);
            IprSheet counts = take_counts(sheet);
            sheets.push_back(std::move(sheet)), sheets.push_back(std::move(counts));
        }
    return sheets;
}

}  // namespace plumb::cli
