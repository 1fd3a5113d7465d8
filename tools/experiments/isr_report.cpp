// plumb experiment isr as numbers: CSV, JSON and text. The keys are a contract (README.md).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/compare_pictures.h"
#include "tools/experiments/isr.h"
#include "tools/shared/sweep.h"
#include "tools/shared/table.h"

namespace plumb::cli {

namespace {

using Optional = std::optional<double>;
using Measures = std::vector<const IsrMeasure*>;

Optional finite(double v) { return std::isfinite(v) ? Optional(v) : std::nullopt; }

Optional mean_of(const std::vector<double>& values) {
    if (values.empty()) return std::nullopt;
    double sum = 0;
    for (const double v : values) sum += v;
    return finite(sum / double(values.size()));
}

class Numbers {
  public:
    std::vector<IsrNumber> all;
    void at(const std::string& table, const std::string& scene, const std::string& row) {
        table_ = table, scene_ = scene, row_ = row;
    }
    void add(const std::string& quantity, const std::string& unit, Optional value, Optional thesis = {}) {
        all.push_back({table_, scene_, row_, quantity, unit, value, thesis});
    }

  private:
    std::string table_, scene_, row_;
};

// The figures that the thesis states of a group of views.
struct Stated {
    Optional least_gain, largest_gain, mean_gain, median_gain, positive, direct_pearson, isr_pearson, improved;
};
Stated stated_of(const std::string& group) {
    if (group == "all") return {0.21, 14.69, 5.88, 7.18, 100, 0.8867, 0.8870, 99.05};
    if (group.find("simple") != std::string::npos) return {0.21, 3.34, {}, {}, 100, {}, {}, {}};
    if (group.find("complex") != std::string::npos) return {2.51, 14.69, {}, {}, 100, {}, {}, {}};
    return {};
}

struct IsrSetting {
    std::string name, kind;  // "published", "corrected", "best"
    bool published;
    IsrK k;
    bool own = false;  // against what ISR means to compute, and not against all bounces
};
// The thesis', ours by default, ours without the environment's light, and the best of ours.
std::vector<IsrSetting> shown_settings(const IsrResult& result) {
    const IsrK& best = result.best;
    return {{"published, k_ssao = 0.5, k_isr = 0.5", "published", true, {0.5, 0.5}},
            {"corrected, ambient = environment", "corrected", false, {0, 1}},
            {"corrected, ambient = none", "without ambient", false, {0, 1, false}},
            {fmt::format("corrected at its best, k_ssao = {:g}, k_isr = {:g}, ambient = {}", best.ssao, best.isr,
                         best.ambient ? "environment" : "none"),
             "best", false, best},
            {"corrected, ambient = none, against one bounce", "own transport", false, {0, 1, false}, true}};
}
const IsrMeasure& measure_of(const IsrViewResult& view, const IsrSetting& s) {
    if (s.own) return view.own_isr;
    return s.published ? view.published.at(isr_grid_index(s.k.ssao, s.k.isr)) : isr_measure_of(view, s.k);
}

const IsrMeasure& direct_of(const IsrViewResult& view, const IsrSetting& s) { return s.own ? view.own_direct : view.direct; }

// The largest k_isr of the grid, at this k_ssao, whose correlation is above direct light's (5.3.2).
Optional retuned(const IsrViewResult& view, const IsrSetting& s) {
    if (s.own) return std::nullopt;
    for (int i = 10; i >= 1; --i) {
        const IsrMeasure& m = measure_of(view, {s.name, s.kind, s.published, {s.k.ssao, i / 10.0, s.k.ambient}});
        if (m.pearson && view.direct.pearson && *m.pearson > *view.direct.pearson) return i / 10.0;
    }
    return std::nullopt;
}

void add_summary(Numbers& n, const std::string& group, const std::vector<const IsrViewResult*>& views,
                 const IsrSetting& setting) {
    const bool thesis_row = setting.published;
    const Stated stated = thesis_row ? stated_of(group) : Stated{};
    std::vector<double> gains, direct, isr, direct_pearson, isr_pearson, improved, worse, not_worse, linear_direct, linear, noise;
    int positive = 0, no_worse = 0, falls = 0, mended = 0, correlated = 0;
    for (const IsrViewResult* v : views) {
        const IsrMeasure &m = measure_of(*v, setting), &dl = direct_of(*v, setting);
        gains.push_back(100 * compare::gain(dl.mean_error, m.mean_error).value_or(0));
        positive += m.mean_error < dl.mean_error, no_worse += m.mean_error <= dl.mean_error;
        direct.push_back(dl.mean_error), isr.push_back(m.mean_error);
        linear_direct.push_back(dl.linear_error), linear.push_back(m.linear_error);
        improved.push_back(100 * m.improved), worse.push_back(100 * m.worse), noise.push_back(v->display_noise);
        not_worse.push_back(100 * (1 - m.worse));
        if (!m.pearson || !dl.pearson) continue;
        ++correlated;
        direct_pearson.push_back(*dl.pearson), isr_pearson.push_back(*m.pearson);
        if (*m.pearson > *dl.pearson) continue;
        ++falls;
        mended += retuned(*v, setting).has_value();
    }
    n.at("summary", group, setting.name);
    n.add("views", "", double(views.size()));
    n.add("gain, least", "%", finite(quantile(gains, 0)), stated.least_gain);
    n.add("gain, mean", "%", mean_of(gains), stated.mean_gain);
    n.add("gain, median", "%", finite(quantile(gains, 0.5)), stated.median_gain);
    n.add("gain, largest", "%", finite(quantile(gains, 1)), stated.largest_gain);
    n.add("views with gain", "%", 100.0 * positive / double(views.size()), stated.positive);
    n.add("views not worse", "%", 100.0 * no_worse / double(views.size()));
    n.add("mean error of DL", "", mean_of(direct));
    n.add("mean error of ISR", "", mean_of(isr));
    n.add("mean error by the truth's noise", "", mean_of(noise));
    n.add("correlation of DL", "", mean_of(direct_pearson), stated.direct_pearson);
    n.add("correlation of ISR", "", mean_of(isr_pearson), stated.isr_pearson);
    n.add("views whose correlation falls", "", falls);
    n.add("of these, mended by a smaller k_isr", "", mended);
    n.add("pixels improved", "%", mean_of(improved), stated.improved);
    n.add("pixels made worse", "%", mean_of(worse));
    n.add("pixels not worse", "%", mean_of(not_worse));
    n.add("linear error of DL", "%", mean_of(linear_direct) ? Optional(100 * *mean_of(linear_direct)) : std::nullopt);
    n.add("linear error of ISR", "%", mean_of(linear) ? Optional(100 * *mean_of(linear)) : std::nullopt);
}

void add_views(Numbers& n, const IsrResult& result) {
    for (const IsrViewResult& v : result.views) {
        n.at("views", v.group, v.name);
        n.add("triangles", "", double(v.triangles));
        n.add("exposure", "", v.exposure);
        n.add("noise of the truth", "%", 100 * v.truth_noise);
        n.add("mean error by the truth's noise", "", v.display_noise);
        n.add("time of the truth", "ms", v.truth_ms);
        n.add("time of DL", "ms", v.direct_ms);
        n.add("time of ISR", "ms", v.isr_ms);
        n.add("mean error of DL", "", v.direct.mean_error);
        n.add("correlation of DL", "", v.direct.pearson);
        n.add("linear error of DL", "%", 100 * v.direct.linear_error);
        n.add("mean error of DL, own transport", "", v.own_direct.mean_error);
        n.add("noise of the truth, own transport", "%", 100 * v.own_noise);
        for (const IsrSetting& s : shown_settings(result)) {
            const IsrMeasure& m = measure_of(v, s);
            const std::string what = ", " + s.kind;
            n.add("mean error of ISR" + what, "", m.mean_error);
            n.add("gain" + what, "%", 100 * compare::gain(direct_of(v, s).mean_error, m.mean_error).value_or(0));
            n.add("correlation of ISR" + what, "", m.pearson);
            n.add("linear error of ISR" + what, "%", 100 * m.linear_error);
            n.add("pixels improved" + what, "%", 100 * m.improved);
            n.add("pixels made worse" + what, "%", 100 * m.worse);
            n.add("retuned k_isr" + what, "", retuned(v, s));
        }
    }
}

void add_reach(Numbers& n, const IsrReach& reach) {
    n.add("reach, over the height", "%", reach.rings > 0 ? Optional(100 * reach.of_height) : std::nullopt);
}

void add_times(Numbers& n, const IsrResult& result) {
    const IsrRequest& r = result.request;
    n.at("reach", "", fmt::format("views, {} x {}", r.size.x, r.size.y));
    n.add("rings", "", result.reach.rings);
    add_reach(n, result.reach);
    for (const IsrTime& t : result.times) {
        n.at("5.7", result.time_view, t.samples == 0 ? "direct light" : fmt::format("{} samples", t.samples));
        n.add("samples", "", t.samples);
        n.add("frame", "ms", t.frame_ms);
        n.add("stages of ISR", "ms", t.isr_ms);
        add_reach(n, t.reach);
    }
    double direct = 0, isr = 0, truth = 0, pov = 0;
    int rendered = 0;
    for (const IsrViewResult& v : result.views) direct += v.direct_ms, isr += v.isr_ms, truth += v.truth_ms;
    for (const IsrPov& p : result.pov)
        if (p.failed.empty()) pov += 1e3 * p.published_s, ++rendered;
    auto row = [&](const char* name, double ms, int views, Optional total, Optional average, Optional fps) {
        if (views == 0) return;
        n.at("2", "", name);
        n.add("views", "", views);
        n.add("total", "s", ms * 1e-3, total);
        n.add("average", "s", ms * 1e-3 / views, average);
        n.add("rate", "FPS", finite(views / (ms * 1e-3)), fps);
    };
    const int views = int(result.views.size());
    row("direct lighting", direct, views, 1.64, 0.00722, 138.41463);
    row("ISR", isr, views, 2.02, 0.00889, 112.48761);
    row("path tracer", truth, views, {}, {}, {});
    row("POV-Ray", pov, rendered, 168070.0, 740.39648, 0.00135);
    n.at("2", "", "t_ISR");
    n.add("average", "ms", (isr - direct) / std::max(1, views), 1.674);
}

void add_rest(Numbers& n, const IsrResult& result) {
    for (const IsrPov& p : result.pov) {
        if (!p.failed.empty()) continue;
        n.at("pov", "", p.name);
        n.add("time, published", "s", p.published_s);
        n.add("time, physical", "s", p.physical_s);
        n.add("mean error of DL", "", p.direct_error);
        n.add("mean error of ISR", "", p.isr_error);
        n.add("mean error of the path tracer", "", p.truth_error);
        n.add("gain", "%", 100 * compare::gain(p.direct_error, p.isr_error).value_or(0));
        n.add("correlation of DL", "", p.direct_pearson);
        n.add("correlation of ISR", "", p.isr_pearson);
        n.add("pixels improved", "%", 100 * p.improved);
        n.add("pixels made worse", "%", 100 * p.worse);
    }
    for (const IsrBeyond& b : result.beyond) {
        if (!b.refused.empty()) continue;
        n.at("beyond", "all", b.sets.empty() ? "ISR" : fmt::format("{}", fmt::join(b.sets, " ")));
        n.add("relative time", "%", finite(100 * b.relative_time));
        n.add("relative error", "%", finite(100 * b.relative_error));
        n.add("time", "ms", mean_of(b.ms));
        n.add("linear error", "%", 100 * mean_of(b.error).value_or(0));
        n.add("mean error", "", mean_of(b.display_error));
        n.add("front", "", double(b.front));
    }
    for (const IsrTurningView& v : result.turning)
        for (const IsrTurning& t : v.settings) {
            if (!t.refused.empty()) continue;
            const IsrSpread s = isr_spread(t, v.truth);
            n.at("turning", v.name, t.setting);
            n.add("points", "", s.points);
            n.add("times seen", "", s.seen);
            n.add("truth", "W/m2", mean_of(v.truth));
            n.add("mean", "% of the truth", finite(100 * s.mean));
            n.add("standard deviation", "% of the truth", finite(100 * s.deviation));
            n.add("range", "% of the truth", finite(100 * s.range));
            n.add("standard deviation over the mean", "%", finite(100 * s.relative));
        }
}

std::vector<std::string> groups_of(const IsrResult& result) {
    std::vector<std::string> groups{"all"};
    for (const IsrViewResult& v : result.views)
        if (std::find(groups.begin(), groups.end(), v.group) == groups.end()) groups.push_back(v.group);
    return groups;
}

}  // namespace

std::string isr_value_text(const IsrNumber& n) {
    if (!n.value) return "";
    if (n.unit.starts_with("%")) return fmt::format("{:.2f}", *n.value);
    return std::trunc(*n.value) == *n.value && std::fabs(*n.value) < 1e9 ? fmt::format("{:.0f}", *n.value)
                                                                         : fmt::format("{:.5g}", *n.value);
}

std::vector<IsrNumber> isr_numbers(const IsrResult& result) {
    Numbers n;
    for (const std::string& group : groups_of(result)) {
        std::vector<const IsrViewResult*> views;
        for (const IsrViewResult& v : result.views)
            if (group == "all" || v.group == group) views.push_back(&v);
        for (const IsrSetting& s : shown_settings(result)) add_summary(n, group, views, s);
    }
    add_times(n, result);
    add_rest(n, result);
    add_views(n, result);
    return std::move(n.all);
}

Json isr_json(const IsrResult& result, const std::vector<IsrNumber>& numbers) {
    auto optional = [](const Optional& v) { return v ? Json(*v) : Json(nullptr); };
    Json rows = Json::array(), refused = Json::array();
    for (const IsrNumber& n : numbers) {
        Json row = {{"table", n.table},       {"scene", n.scene}, {"row", n.row},
                    {"quantity", n.quantity}, {"unit", n.unit},   {"value", optional(n.value)}};
        if (n.thesis) row["thesis"] = *n.thesis;
        rows.push_back(row);
    }
    for (const IsrBeyond& b : result.beyond)
        if (!b.refused.empty()) refused.push_back({{"settings", b.sets}, {"reason", b.refused}});
    for (const IsrPov& p : result.pov)
        if (!p.failed.empty()) refused.push_back({{"view", p.name}, {"reason", p.failed}});
    const IsrRequest& r = result.request;
    return {{"processor", result.processor},
            {"isa", result.isa},
            {"threads", result.threads},
            {"load_before", optional(finite(result.load_before))},
            {"load_after", optional(finite(result.load_after))},
            {"lists", r.lists},
            {"size", {r.size.x, r.size.y}},
            {"time_size", {r.time_size.x, r.time_size.y}},
            {"samples", r.samples},
            {"repeats", r.repeats},
            {"best", {{"k_ssao", result.best.ssao}, {"k_isr", result.best.isr}, {"ambient", result.best.ambient}}},
            {"left_out", refused},
            {"numbers", rows}};
}

std::string isr_text(const IsrResult& result, const std::vector<IsrNumber>& numbers) {
    std::vector<std::vector<std::string>> cells;
    for (const IsrNumber& n : numbers)
        if (n.table != "views" && n.table != "turning")
            cells.push_back({n.table, n.scene, n.row, n.quantity, isr_value_text(n), n.unit,
                             n.thesis ? fmt::format("{:g}", *n.thesis) : ""});
    std::string text = format_table(
        {{"table"}, {"of"}, {"row"}, {"quantity"}, {"ours", Align::right}, {"unit"}, {"ISR", Align::right}}, cells);
    for (const IsrBeyond& b : result.beyond)
        if (!b.refused.empty()) text += fmt::format("left out: {}: {}\n", fmt::join(b.sets, " "), b.refused);
    for (const IsrPov& p : result.pov)
        if (!p.failed.empty()) text += fmt::format("POV-Ray, {}: {}\n", p.name, p.failed);
    return text;
}

}  // namespace plumb::cli
