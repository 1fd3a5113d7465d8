#include "tools/plumb/lightmap_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "io/file.h"
#include "tools/page/page.h"
#include "tools/shared/table.h"

namespace plumb::cli {

namespace {

using probes::Bleeding;
using probes::BleedingKind;
using probes::ChartCheck;
using probes::Leak;
using probes::LeakKind;
using probes::Place;
using probes::Seam;

constexpr std::size_t most_rows = 10;  // of a list: the rest is counted
constexpr probes::CheckParams params;  // as check_user_lightmap() leaves them

const char* name_of(LeakKind kind) { return kind == LeakKind::black ? "no path found light" : "lit less"; }
const char* name_of(BleedingKind kind) {
    return kind == BleedingKind::unwritten ? "unwritten" : kind == BleedingKind::other_chart ? "another chart" : "another value";
}

std::string percent(double share) { return share >= 9.995 ? fmt::format("{:.0f} %", 100 * share) : fmt::format("{:.3g} %", 100 * share); }
std::string percent(std::optional<double> share) { return share ? percent(*share) : "undefined"; }

std::string mesh_name(const LightmapReport& r, int object) { return io::printable(r.scene.scene.meshes[std::size_t(object)].name); }
std::string texel_text(const glm::ivec2& t) { return fmt::format("{},{}", t.x, t.y); }
std::string position_text(const glm::dvec3& p) { return fmt::format("{:.4g}, {:.4g}, {:.4g}", p.x, p.y, p.z); }

// Charts that are off, by how far.
std::vector<ChartCheck> charts_off(const LightmapReport& r) {
    std::vector<ChartCheck> off;
    for (const ChartCheck& c : r.check.charts)
        if (c.off) off.push_back(c);
    std::stable_sort(off.begin(), off.end(), [](const ChartCheck& a, const ChartCheck& b) { return std::fabs(a.bias) > std::fabs(b.bias); });
    return off;
}

int count_of(const LightmapReport& r, BleedingKind kind) {
    return int(std::count_if(r.check.bleeding.begin(), r.check.bleeding.end(), [&](const Bleeding& b) { return b.kind == kind; }));
}

// A list of findings, as text and page show it.
struct Finding {
    std::string title;
    std::vector<Column> columns;
    std::vector<std::vector<std::string>> rows;
    std::size_t count = 0;  // of which there are
};

Finding chart_finding(const LightmapReport& r) {
    const std::vector<ChartCheck> off = charts_off(r);
    Finding f{"charts that are off", {{"chart", Align::right}, {"mesh"}, {"texels"}, {"bias", Align::right}, {"+-", Align::right}, {"rms", Align::right}}, {}, off.size()};
    for (std::size_t i = 0; i < std::min(off.size(), most_rows); ++i) {
        const probes::Chart& c = r.lightmap.atlas.charts[std::size_t(off[i].chart)];
        f.rows.push_back({std::to_string(off[i].chart), mesh_name(r, c.object),
                          fmt::format("{} to {}", texel_text(c.origin), texel_text(c.origin + c.size - 1)),
                          (off[i].bias > 0 ? "+" : "-") + percent(std::fabs(off[i].bias)), percent(off[i].bias_error), percent(off[i].rms)});
    }
    return f;
}

Finding seam_finding(const LightmapReport& r) {
    Finding f{"seams", {{"excess", Align::right}, {"meshes"}, {"texels"}, {"at, m"}, {"map", Align::right}, {"truth", Align::right}, {"smooth"}}, {}, std::size_t(r.check.seams_off)};
    for (std::size_t i = 0; i < std::min(std::size_t(r.check.seams_off), most_rows); ++i) {
        const Seam& s = r.check.seams[i];
        f.rows.push_back({percent(s.excess), mesh_name(r, s.a.object) + (s.a.object == s.b.object ? "" : " | " + mesh_name(r, s.b.object)),
                          texel_text(s.a.texel) + " | " + texel_text(s.b.texel), position_text(s.a.position),
                          fmt::format("{:.4g} | {:.4g}", s.a.user, s.b.user), fmt::format("{:.4g} | {:.4g}", s.a.truth, s.b.truth),
                          s.smooth ? "yes" : "no"});
    }
    return f;
}

Finding leak_finding(const LightmapReport& r) {
    Finding f{"leaks", {{"texels", Align::right}, {"kind"}, {"worst"}, {"mesh"}, {"at, m"}, {"map", Align::right}, {"truth", Align::right}}, {}, r.check.leaks.size()};
    for (std::size_t i = 0; i < std::min(r.check.leaks.size(), most_rows); ++i) {
        const Leak& l = r.check.leaks[i];
        f.rows.push_back({std::to_string(l.texels), name_of(l.kind), texel_text(l.worst.texel), mesh_name(r, l.worst.object),
                          position_text(l.worst.position), fmt::format("{:.4g}", l.worst.user), fmt::format("{:.4g}", l.worst.truth)});
    }
    return f;
}

Finding bleeding_finding(const LightmapReport& r) {
    std::vector<Bleeding> worst = r.check.bleeding;
    std::stable_sort(worst.begin(), worst.end(), [](const Bleeding& a, const Bleeding& b) {
        return std::fabs(a.place.user - a.place.truth) > std::fabs(b.place.user - b.place.truth);
    });
    Finding f{"texels beside charts that bleed", {{"texel"}, {"kind"}, {"mesh"}, {"at, m"}, {"map", Align::right}, {"chart", Align::right}}, {}, worst.size()};
    for (std::size_t i = 0; i < std::min(worst.size(), most_rows); ++i) {
        const Place& p = worst[i].place;
        f.rows.push_back({texel_text(p.texel), name_of(worst[i].kind), mesh_name(r, p.object), position_text(p.position),
                          fmt::format("{:.4g}", p.user), fmt::format("{:.4g}", p.truth)});
    }
    return f;
}

std::vector<Finding> findings(const LightmapReport& r) { return {chart_finding(r), seam_finding(r), leak_finding(r), bleeding_finding(r)}; }

// What both the text and the page begin with: name, value.
std::vector<std::vector<std::string>> figures(const LightmapReport& r) {
    const probes::LightmapCheck& c = r.check;
    std::vector<std::vector<std::string>> rows = {
        {"map", fmt::format("{}, {} x {} texels, times {}", io::shown(r.given.checked), r.lightmap.atlas.size.x, r.lightmap.atlas.size.y, r.given.scale)},
        {"truth", fmt::format("irradiance, W/m2, {}; {} receivers, {} paths each; standard error {:.2g} % of the mean, {:.4g}", r.given.part,
                              r.lightmap.receivers.count(), r.truth.samples, 100 * r.truth.relative_error, c.errors.mean_truth.value_or(0))},
        {"error", fmt::format("rms {} of the mean{}, bias {}", percent(c.errors.rms), c.errors.below_noise ? " (within the noise)" : "",
                              c.errors.mean_error ? fmt::format("{:+.3g} %", 100 * *c.errors.mean_error) : "undefined")},
        {"told from noise", fmt::format("{} of the receivers differ by more than {:.3g} standard errors (by chance {}), with {} of the squared error",
                                        percent(c.told), c.sigmas, percent(c.told_by_chance), percent(c.told_energy))},
        {"seams", fmt::format("{} of {} edges between charts differ by more than {} beyond the truth; mean {}, worst {}{}", c.seams_off, c.seams.size(), percent(params.seam),
                              percent(c.seam_mean), c.seams.empty() ? "none" : percent(c.seams[0].excess),
                              c.seams_unknown > 0 ? fmt::format("; {} more have no receivers beside them", c.seams_unknown) : "")},
        {"smooth seams", fmt::format("the map differs by {} of the light on both sides, the best one of this layout by {}", percent(c.smooth_user),
                                     percent(c.smooth_truth))},
        {"leaks", fmt::format("{} texels with light where there is less than half of it, {} where no path found any, in {} places", c.leaking, c.black_leaking, c.leaks.size())},
        {"beside charts", fmt::format("of {} texels that lookups read: {} unwritten, {} another chart's, {} another value; {} too far from the next receiver to tell",
                                      c.read_beside, count_of(r, BleedingKind::unwritten), count_of(r, BleedingKind::other_chart),
                                      count_of(r, BleedingKind::wrong), c.read_unknown)}};
    if (c.worst)
        rows.push_back({"worst", fmt::format("texel {} of \"{}\" at {} m: {:.4g} where {:.4g} +- {:.2g} is right", texel_text(c.worst->texel),
                                             mesh_name(r, c.worst->object), position_text(c.worst->position), c.worst->user, c.worst->truth, c.worst->error)});
    if (r.truth.relative_error > 0.05)
        rows.push_back({"note", "the truth is noisy: what lies in its noise is not called wrong; more --samples tell more"});
    if (c.inside > 0)
        rows.push_back({"inside", fmt::format("{} receivers lie in something and are not compared; beside what they lie in, rms {}", c.inside, percent(c.inside_errors.rms))});
    if (c.errors.rms && c.rms_at_best_scale < *c.errors.rms / 2 && std::fabs(c.best_scale - 1) > 0.05)
        rows.push_back({"scale", fmt::format("another --scale, {:.4g} times this one, would leave an rms of {}", c.best_scale, percent(c.rms_at_best_scale))});
    return rows;
}

Json place_json(const LightmapReport& r, const Place& p) {
    return {{"texel", {p.texel.x, p.texel.y}}, {"mesh", r.scene.scene.meshes[std::size_t(p.object)].name}, {"chart", p.chart},
            {"position", {p.position.x, p.position.y, p.position.z}}, {"map", p.user}, {"truth", p.truth}, {"error", p.error}};
}

Json number(std::optional<double> value) { return value && std::isfinite(*value) ? Json(*value) : Json(nullptr); }

Json errors_json(const compare::SignedErrors& e) {
    return {{"receivers", e.pixels}, {"mean_truth", number(e.mean_truth)}, {"bias", number(e.mean_error)}, {"rms", number(e.rms)},
            {"noise", number(e.noise)}, {"below_noise", e.below_noise}, {"too_dark", e.too_dark}, {"too_bright", e.too_bright},
            {"removed", number(e.removed)}, {"leaked", number(e.leaked)}};
}

Json charts_json(const LightmapReport& r) {
    Json off = Json::array();
    for (const ChartCheck& c : charts_off(r)) {
        const probes::Chart& chart = r.lightmap.atlas.charts[std::size_t(c.chart)];
        off.push_back({{"chart", c.chart}, {"mesh", r.scene.scene.meshes[std::size_t(chart.object)].name},
                       {"origin", {chart.origin.x, chart.origin.y}}, {"size", {chart.size.x, chart.size.y}}, {"receivers", c.receivers},
                       {"bias", c.bias}, {"bias_error", c.bias_error}, {"rms", c.rms}});
    }
    return {{"count", r.check.charts.size()}, {"off", off}};
}

Json seams_json(const LightmapReport& r) {
    const probes::LightmapCheck& c = r.check;
    Json worst = Json::array();
    for (std::size_t i = 0; i < std::min(c.seams.size(), most_rows); ++i) {
        const Seam& s = c.seams[i];
        if (s.excess == 0) break;
        worst.push_back({{"excess", s.excess}, {"worst", s.worst}, {"map", s.user}, {"truth", s.truth}, {"length_m", s.length}, {"smooth", s.smooth},
                         {"a", place_json(r, s.a)}, {"b", place_json(r, s.b)}});
    }
    return {{"edges", c.seams.size()}, {"off", c.seams_off}, {"unknown", c.seams_unknown}, {"mean", c.seam_mean}, {"smooth_map", c.smooth_user},
            {"smooth_truth", c.smooth_truth}, {"worst", worst}};
}

Json leaks_json(const LightmapReport& r) {
    Json places = Json::array();
    for (std::size_t i = 0; i < std::min(r.check.leaks.size(), most_rows); ++i) {
        const Leak& l = r.check.leaks[i];
        places.push_back({{"texels", l.texels}, {"black", l.kind == LeakKind::black}, {"worst", place_json(r, l.worst)}});
    }
    return {{"texels", r.check.leaking}, {"black_texels", r.check.black_leaking}, {"places", r.check.leaks.size()}, {"largest", places}};
}

constexpr std::string_view cannot_tell = "cannot tell: ";
// Paths rarely find what lights a texel: of few of them all may have missed it, and their error says nothing of it.
constexpr int enough_for_leaks = 64;

std::string conclusion(const LightmapReport& r) {
    if (r.verdict.starts_with(cannot_tell)) return r.verdict;
    if (!r.verdict.empty()) return "disagree: " + r.verdict;
    return r.given.max_error || r.given.max_seam || r.given.max_leaks ? "agree: within the bounds" : "no bound was given";
}

}  // namespace

std::string verdict_of(const LightmapOptions& given, const probes::LightmapCheck& c) {
    if ((given.max_error || given.max_seam || given.max_leaks) && c.errors.pixels == 0)
        return "all receivers lie inside of something: nothing was compared";
    if (given.max_error && !(c.errors.rms && c.rms_least <= *given.max_error))
        return fmt::format("relative RMS error {}: the bound is {}", percent(c.errors.rms), percent(*given.max_error));
    if (given.max_seam && !c.seams.empty() && !(c.seams[0].excess <= *given.max_seam))
        return fmt::format("a seam of {}: the bound is {}", percent(c.seams[0].excess), percent(*given.max_seam));
    if (given.max_leaks && c.leaking + c.black_leaking > *given.max_leaks && c.rounds < enough_for_leaks)
        return fmt::format("{}{} texels look like leaks, and of {} paths each the noise is not known well enough: --samples {} or more", cannot_tell,
                           c.leaking + c.black_leaking, c.rounds, enough_for_leaks);
    if (given.max_leaks && c.leaking + c.black_leaking > *given.max_leaks)
        return fmt::format("{} texels leak: the bound is {}", c.leaking + c.black_leaking, *given.max_leaks);
    if (given.max_error && c.rms_most > *given.max_error)
        return fmt::format("{}the relative RMS error is {} to {} for all that this noise tells, the bound is {}: more --samples",
                           cannot_tell, percent(c.rms_least), percent(c.rms_most), percent(*given.max_error));
    return "";
}

std::string lightmap_text(const LightmapReport& r) {
    std::string text = format_table({{""}, {""}}, figures(r));
    for (const Finding& f : findings(r)) {
        if (f.rows.empty()) continue;
        text += fmt::format("\n{}{}\n", f.title, f.count > f.rows.size() ? fmt::format(", the first {} of {}", f.rows.size(), f.count) : "");
        text += format_table(f.columns, f.rows, 2);
    }
    return text + "\n" + conclusion(r) + "\n";
}

Json lightmap_json(const LightmapReport& r) {
    const probes::LightmapCheck& c = r.check;
    Json json = {{"version", 1},
                 {"agree", r.verdict.empty()},
                 {"reason", r.verdict},
                 {"quantity", "irradiance"},
                 {"unit", "W/m2"},
                 {"part", r.given.part},
                 {"uv", r.layout},
                 {"lightmap", {r.lightmap.atlas.size.x, r.lightmap.atlas.size.y}},
                 {"samples", r.truth.samples},
                 {"rounds", r.truth.rounds},
                 {"relative_error_of_truth", r.truth.relative_error},
                 {"errors", errors_json(c.errors)},
                 {"told", {{"share", c.told}, {"by_chance", c.told_by_chance}, {"of_squared_error", c.told_energy}}},
                 {"worst", c.worst ? place_json(r, *c.worst) : Json(nullptr)},
                 {"best_scale", {{"scale", c.best_scale}, {"rms", c.rms_at_best_scale}}},
                 {"inside", {{"receivers", c.inside}, {"rms", number(c.inside_errors.rms)}}},
                 {"charts", charts_json(r)},
                 {"seams", seams_json(r)},
                 {"leaks", leaks_json(r)}};
    Json beside = {{"read", c.read_beside}, {"unknown", c.read_unknown}, {"unwritten", count_of(r, BleedingKind::unwritten)},
                   {"other_chart", count_of(r, BleedingKind::other_chart)}, {"wrong", count_of(r, BleedingKind::wrong)}};
    beside["first"] = c.bleeding.empty() ? Json(nullptr) : place_json(r, c.bleeding[0].place);
    json["beside_charts"] = beside;
    return json;
}

std::string lightmap_page(const LightmapReport& r, const std::vector<probes::DebugLayer>& pictures) {
    page::Page page("plumb lightmap --check, " + r.given.checked);
    page.paragraph(conclusion(r) + ".");
    const auto cells_of = [](const std::vector<std::string>& texts) {
        std::vector<page::Cell> cells;
        for (const std::string& text : texts) cells.push_back({text});
        return cells;
    };
    std::vector<std::vector<page::Cell>> rows = {cells_of({"figure", "value"})};
    for (const std::vector<std::string>& row : figures(r)) rows.push_back(cells_of(row));
    page.table(rows, fmt::format("Of luminance. Nothing is called wrong that {:.3g} standard errors explain.", r.check.sigmas));
    for (const Finding& f : findings(r)) {
        page.heading(f.title);
        if (f.rows.empty()) page.paragraph("None.");
        std::vector<std::vector<page::Cell>> cells(1);
        for (const Column& c : f.columns) cells[0].push_back({c.head});
        for (const std::vector<std::string>& row : f.rows) cells.push_back(cells_of(row));
        if (!f.rows.empty()) page.table(cells, fmt::format("{} of {}", f.rows.size(), f.count));
    }
    page.heading("pictures");
    for (const probes::DebugLayer& layer : pictures) page.figure(page.picture(layer.picture, layer.name + ": " + layer.meaning));
    return page.html();
}

}  // namespace plumb::cli
