// plumb experiment probe-ladder: tables, JSON, and where a curve flattens.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "io/file.h"
#include "tools/experiments/probe_ladder.h"
#include "tools/shared/reports.h"
#include "tools/shared/table.h"

namespace plumb::cli {

LadderStep own_step(const std::string& axis) {
    static const std::map<std::string, LadderStep> steps = {
        {"probes", step_unseen},   {"overlaps", step_unseen}, {"placement", step_unseen},   {"degree", step_degree},
        {"relight", step_relight}, {"rays", step_rays},       {"clusters", step_truncation}};
    const auto at = steps.find(axis);
    return at == steps.end() ? ladder_steps : at->second;
}

int flat_from(const std::vector<std::pair<double, double>>& cost_and_error) {
    for (std::size_t a = 0; a < cost_and_error.size(); ++a) {
        bool pays = false;
        for (std::size_t b = a + 1; b < cost_and_error.size(); ++b) {
            const auto& [cost_a, error_a] = cost_and_error[a];
            const auto& [cost_b, error_b] = cost_and_error[b];
            pays = pays || (error_b < error_a && error_a * cost_a >= error_b * cost_b);
        }
        if (!pays) return int(a);
    }
    return -1;
}

std::vector<bool> on_front(const std::vector<std::pair<double, double>>& cost_and_error) {
    std::vector<bool> front;
    for (const auto& [cost, error] : cost_and_error)
        front.push_back(std::none_of(cost_and_error.begin(), cost_and_error.end(), [&, c = cost, e = error](const auto& other) {
            return other.first <= c && other.second <= e && (other.first < c || other.second < e);
        }));
    return front;
}

std::vector<std::pair<std::string, std::vector<const LadderRung*>>> lines_of(const Ladder& ladder, const std::string& axis) {
    std::vector<std::pair<std::string, std::vector<const LadderRung*>>> lines;
    for (const LadderRung& r : ladder.rungs) {
        if (r.axis != axis) continue;
        auto line = std::find_if(lines.begin(), lines.end(), [&](const auto& l) { return l.first == r.line; });
        if (line == lines.end()) line = lines.insert(lines.end(), {r.line, {}});
        line->second.push_back(&r);
    }
    return lines;
}

namespace {

std::string percent(double share) { return share < 0 ? "" : fmt::format("{:.3g}", 100 * share); }

std::vector<Column> heads() {
    std::vector<Column> columns = {{"rung"}};
    for (const char* head : {"rms %", "local %", "bias %", "95 % err less, %", "black %"})
        columns.push_back({head, Align::right});
    for (const char* step : ladder_step_names) columns.push_back({step, Align::right});
    for (const char* head : {"other sets", "lookup", "M rays", "s", "MB", "M products"})
        columns.push_back({head, Align::right});
    return columns;
}

std::vector<std::string> row_of(const LadderRung& r) {
    std::vector<std::string> row = {fmt::format("{}{}", r.axis == "products" ? r.settings : fmt::format("{:g}", r.value),
                                                r.is_default ? " (default)" : "")};
    const LadderErrors& e = r.errors;
    row.push_back(percent(e.rms)), row.push_back(percent(e.local)), row.push_back(fmt::format("{:+.2f}", 100 * e.bias));
    row.push_back(percent(e.p95)), row.push_back(percent(e.black));
    for (const double step : e.step_local) row.push_back(r.axis == "receivers" ? "" : percent(step));
    std::string others;
    if (!r.others.empty()) {
        const auto [low, high] = std::minmax_element(r.others.begin(), r.others.end());
        others = percent(*low) + " to " + percent(*high);
    }
    row.push_back(others), row.push_back(percent(r.lookup));
    if (r.bytes == 0) {
        row.resize(row.size() + 4);
        return row;
    }
    row.push_back(fmt::format("{:.2f}", double(r.rays) / 1e6)), row.push_back(fmt::format("{:.2f}", r.seconds));
    row.push_back(fmt::format("{:.2f}", double(r.bytes) / 1e6)), row.push_back(fmt::format("{:.2f}", r.products / 1e6));
    return row;
}

using Cost = double (*)(const LadderRung&);
struct NamedCost {
    const char* name;
    Cost of;
};
constexpr NamedCost costs[] = {{"rays", [](const LadderRung& r) { return double(r.rays); }},
                               {"seconds", [](const LadderRung& r) { return r.seconds; }},
                               {"bytes", [](const LadderRung& r) { return double(r.bytes); }},
                               {"products", [](const LadderRung& r) { return r.products; }}};

std::string flat_at(const std::vector<const LadderRung*>& line, const NamedCost& cost) {
    std::vector<std::pair<double, double>> points;
    for (const LadderRung* r : line) points.push_back({cost.of(*r), r->errors.local});
    return fmt::format("{:g}", line[std::size_t(flat_from(points))]->value);
}

std::string settled_at(const std::string& axis, const std::vector<const LadderRung*>& line) {
    const LadderStep step = own_step(axis);
    if (step == ladder_steps) return "";
    for (const LadderRung* r : line) {
        const double own = r->errors.step_local[step], all = r->errors.local;
        if (own * own <= (1 - 0.95 * 0.95) * all * all) return fmt::format("{:g}", r->value);
    }
    return "never";
}

std::string flat_text(const LadderFlat& f) {
    std::string text = fmt::format(
        "from there on no rung halves the error for twice the cost: {} by rays, {} by seconds, {} by bytes, {} by products",
        f.rays, f.seconds, f.bytes, f.products);
    if (!f.settled.empty())
        text += fmt::format("; its own step ({}) makes less than 5 % of the error from: {}",
                            ladder_step_names[own_step(f.axis)], f.settled);
    return text + "\n";
}

std::string front_text(const Ladder& ladder, const NamedCost& cost) {
    std::vector<const LadderRung*> whole;
    std::vector<std::pair<double, double>> points;
    for (const LadderRung& r : ladder.rungs) {
        if (r.bytes == 0 || r.axis == "receivers" || (r.is_default && r.axis != "default") ||
            (r.axis == "relight" && r.line != "quadrature weights"))
            continue;
        whole.push_back(&r), points.push_back({cost.of(r), r.errors.local});
    }
    const std::vector<bool> front = on_front(points);
    std::vector<std::vector<std::string>> rows;
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < whole.size(); ++i)
        if (front[i] || i == 0) order.push_back(i);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return points[a].first < points[b].first; });
    for (const std::size_t i : order) {
        const LadderRung& r = *whole[i];
        rows.push_back({r.axis == "default" ? "default" : r.settings, percent(r.errors.rms), percent(r.errors.local),
                        percent(r.errors.black), fmt::format("{:.2f}", double(r.rays) / 1e6), fmt::format("{:.2f}", r.seconds),
                        fmt::format("{:.2f}", double(r.bytes) / 1e6), fmt::format("{:.2f}", r.products / 1e6),
                        front[i] ? "" : "beaten"});
    }
    return fmt::format("\nlocal error against {}: what nothing beats, and the default\n\n", cost.name) +
           format_table({{"setting"},
                         {"rms %", Align::right},
                         {"local %", Align::right},
                         {"black %", Align::right},
                         {"M rays", Align::right},
                         {"s", Align::right},
                         {"MB", Align::right},
                         {"M products", Align::right},
                         {""}},
                        rows);
}

}  // namespace

std::vector<LadderFlat> flats_of(const Ladder& ladder) {
    std::vector<LadderFlat> flats;
    for (const std::string& axis : ladder_axes) {
        if (axis == "products" || axis == "placement" || axis == "window") continue;
        for (const auto& [line, rungs] : lines_of(ladder, axis))
            flats.push_back({axis, line, flat_at(rungs, costs[0]), flat_at(rungs, costs[1]), flat_at(rungs, costs[2]),
                             flat_at(rungs, costs[3]), settled_at(axis, rungs)});
    }
    return flats;
}

std::string ladder_text(const Ladder& ladder) {
    std::string text = fmt::format(
        "{}: {} receivers, {} probes; held against {} receivers ({} more see too much sky) of {} rays each, known to {:.2g} %; "
        "the step degree to {:.2g} %\n"
        "rms, bias, 95 %: of the mean irradiance; local: root mean square of error / (truth + mean), and so what each step "
        "adds; black: of "
        "what is lit\n"
        "M products: multiply-adds of one relighting, a channel; s: wall time of one run\n",
        io::stem_of(ladder.scene), ladder.receivers, ladder.probes, ladder.checked, ladder.before_sky,
        ladder.request.check.truth_rays, 100 * ladder.uncertainty, 100 * ladder.many_uncertainty);
    const std::vector<LadderFlat> flats = flats_of(ladder);
    for (const std::string& axis : ladder_axes)
        for (const auto& [line, rungs] : lines_of(ladder, axis)) {
            text += fmt::format("\n{}{}\n\n", axis, line == axis ? "" : ", " + line);
            std::vector<std::vector<std::string>> rows;
            for (const LadderRung* r : rungs) rows.push_back(row_of(*r));
            text += format_table(heads(), rows);
            for (const LadderFlat& f : flats)
                if (f.axis == axis && f.line == line) text += flat_text(f);
        }
    for (const NamedCost& cost : costs) text += front_text(ladder, cost);
    for (const std::string& left : ladder.left_out) text += "\nleft out: " + left;
    return text + (ladder.left_out.empty() ? "" : "\n");
}

std::string ladder_json(const Ladder& ladder) {
    Json rungs = Json::array();
    for (const LadderRung& r : ladder.rungs) {
        const LadderErrors& e = r.errors;
        Json steps = Json::object();
        for (std::size_t s = 0; s < ladder_steps; ++s)
            steps[ladder_step_names[s]] = {{"rms", e.step_rms[s]}, {"local", e.step_local[s]}, {"bias", e.step_bias[s]}};
        Json rung = {{"axis", r.axis},
                     {"line", r.line},
                     {"value", r.value},
                     {"settings", r.settings},
                     {"is_default", r.is_default},
                     {"probes", r.probes},
                     {"receivers", r.receivers},
                     {"clusters", r.clusters},
                     {"seconds", r.seconds},
                     {"rays", r.rays},
                     {"bytes", r.bytes},
                     {"products", r.products},
                     {"rms", e.rms},
                     {"local", e.local},
                     {"bias", e.bias},
                     {"p95", e.p95},
                     {"black", e.black}};
        if (r.axis == "receivers")
            rung["lookup"] = r.lookup;
        else
            rung["steps"] = steps, rung["truncation_of_singular_values"] = r.tail;
        if (!r.others.empty()) rung["other_directions"] = r.others;
        rungs.push_back(rung);
    }
    return json_text({{"version", 1},
                      {"scene", io::stem_of(ladder.scene)},
                      {"receivers", ladder.receivers},
                      {"probes", ladder.probes},
                      {"checked", ladder.checked},
                      {"left_out_for_sky", ladder.before_sky},
                      {"truth_rays", ladder.request.check.truth_rays},
                      {"mean_irradiance", ladder.mean},
                      {"truth_uncertainty", ladder.uncertainty},
                      {"degree_uncertainty", ladder.many_uncertainty},
                      {"rungs", rungs},
                      {"left_out", ladder.left_out}});
}

}  // namespace plumb::cli
