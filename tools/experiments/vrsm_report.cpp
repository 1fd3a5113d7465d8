// plumb experiment vrsm as numbers: CSV, JSON and text. The keys are a contract (README.md).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "tools/experiments/vrsm.h"
#include "tools/shared/sweep.h"
#include "tools/shared/table.h"

namespace plumb::cli {

namespace {

using compare::SignedErrors;

// VRSM, tables 5.1-5.3 as printed; the overheads of table 5.2 from the text beneath it.
struct Printed {
    double without, with, overhead;
};
constexpr Printed table_5_1[] = {{31.6, 35.9, 14}, {32.4, 36.5, 13}, {33.0, 37.3, 13}};
constexpr Printed table_5_2[] = {{31.6, 35.9, 13}, {79.8, 93.4, 17}};
constexpr double table_5_3_ms[] = {2.03, 2.47, 21.8, 9.60}, table_5_3_percent[] = {5.7, 6.9, 60.7, 26.7};
constexpr double table_5_3_total = 35.9;

std::optional<double> finite(double v) { return std::isfinite(v) ? std::optional(v) : std::nullopt; }
std::optional<double> percent(const std::optional<double>& share) {
    return share ? finite(100 * *share) : std::nullopt;
}

const std::string error_suffix = ", standard error";

double overhead_percent(double without, double with) { return 100 * (with / without - 1); }

// Repetition by repetition: what slows the machine for longer than a frame slows both.
std::vector<double> paired_overheads(const VrsmTimes& without, const VrsmTimes& with) {
    std::vector<double> all;
    for (std::size_t i = 0; i < without.frame_ms.size(); ++i)
        all.push_back(overhead_percent(without.frame_ms[i], with.frame_ms.at(i)));
    return all;
}

class Numbers {
  public:
    std::vector<VrsmNumber> all;

    void at(const std::string& table, const std::string& scene, const std::string& row) {
        table_ = table, scene_ = scene, row_ = row;
    }
    void add(const std::string& quantity, const std::string& unit, std::optional<double> value,
             std::optional<double> thesis = {}) {
        all.push_back({table_, scene_, row_, quantity, unit, value, thesis});
    }

    // A share as its mean over the seeds, and that mean's standard error.
    void add_estimate(const std::string& quantity, const VrsmEstimate& e) {
        add(quantity, "%", percent(e.mean));
        add(quantity + error_suffix, "%", percent(e.error));
    }

    // Times of two settings that only visibility tells apart.
    void add_pair(const VrsmTimes& without, const VrsmTimes& with, const Printed* printed) {
        auto thesis = [&](double Printed::*value) { return printed ? std::optional(printed->*value) : std::nullopt; };
        const double a = median(without.frame_ms), b = median(with.frame_ms);
        const std::vector<double> pairs = paired_overheads(without, with);
        add("without", "ms", finite(a), thesis(&Printed::without));
        add("with", "ms", finite(b), thesis(&Printed::with));
        add("overhead", "%", finite(overhead_percent(a, b)), thesis(&Printed::overhead));
        add("overhead by pairs", "%", finite(median(pairs)));
        add("overhead by pairs, lower quartile", "%", finite(quantile(pairs, 0.25)));
        add("overhead by pairs, upper quartile", "%", finite(quantile(pairs, 0.75)));
        // What disturbs the machine only ever adds.
        const double c = *std::min_element(without.frame_ms.begin(), without.frame_ms.end()),
                     d = *std::min_element(with.frame_ms.begin(), with.frame_ms.end());
        add("fastest without", "ms", finite(c)), add("fastest with", "ms", finite(d));
        add("overhead of the fastest", "%", finite(overhead_percent(c, d)));
        const double s = median(without.pass_ms[2]), t = median(with.pass_ms[2]);
        add("sampling without", "ms", finite(s)), add("sampling with", "ms", finite(t));
        add("sampling overhead", "%", finite(overhead_percent(s, t)));
    }

    void add_passes(const VrsmTimes& times, bool printed) {
        auto thesis = [&](double v) { return printed ? std::optional(v) : std::nullopt; };
        double total = 0;
        for (const auto& pass : times.pass_ms) total += median(pass);
        for (std::size_t p = 0; p < vrsm_passes.size(); ++p) {
            row_ = vrsm_passes[p];
            const double ms = median(times.pass_ms[p]);
            add("time", "ms", finite(ms), thesis(table_5_3_ms[p]));
            add("share", "%", finite(100 * ms / total), thesis(table_5_3_percent[p]));
        }
        row_ = "Total";
        add("time", "ms", finite(total), thesis(table_5_3_total));
        add("share", "%", 100, thesis(100));
    }

    void add_errors(const VrsmErrors& e) {
        add_estimate("mean error", e.estimate(&SignedErrors::mean_error));
        add_estimate("rms", e.rms());
        add("noise", "%", percent(e.estimate(&SignedErrors::noise).mean));
        add_estimate("too dark", e.estimate(&SignedErrors::too_dark));
        add_estimate("too bright", e.estimate(&SignedErrors::too_bright));
        add_estimate("removed", e.estimate(&SignedErrors::removed));
        add_estimate("leaked", e.estimate(&SignedErrors::leaked));
        add_estimate("leak stopped", vrsm_estimate(e.leak_stopped));
        double nonfinite = 0;
        for (const SignedErrors& seed : e.seeds) nonfinite += double(seed.nonfinite);
        add("no number", "pixels", nonfinite);
        add("best", "", double(e.best));
        add("not told apart", "", double(e.tied));
    }

    void add_beyond(const VrsmBeyond& b, const VrsmBeyond& thesis) {
        add("samples", "", b.samples.x * b.samples.y);
        if (!b.ms.empty()) {
            add("time", "ms", finite(median(b.ms)));
            add("relative time", "%", finite(100 * b.relative_time));
        }
        add_estimate("rms", b.estimate(&SignedErrors::rms));
        add_estimate("relative rms", relative_rms(b, thesis));
        add_estimate("mean error", b.estimate(&SignedErrors::mean_error));
        add_estimate("removed", b.estimate(&SignedErrors::removed));
        add_estimate("leaked", b.estimate(&SignedErrors::leaked));
        add("winner", "", double(b.winner));
        add("least rms", "", double(b.least_rms));
    }

    // The setting on the scene where it is worst.
    void add_worst(const Vrsm& result, std::size_t candidate, bool winner) {
        double time = 0;
        VrsmEstimate worst{0, 0};
        for (const VrsmScene& s : result.scenes) {
            const VrsmEstimate here = relative_rms(s.beyond.at(candidate), s.beyond.front());
            if (!worst.mean || !here.mean || *here.mean > *worst.mean) worst = !worst.mean ? worst : here;
            time = std::max(time, s.beyond[candidate].relative_time);
        }
        if (result.request.times) add("largest relative time", "%", finite(100 * time));
        add_estimate("largest relative rms", worst);
        add("winner", "", double(winner));
    }

  private:
    std::string table_, scene_, row_;
};

const Printed* printed_of(const VrsmScene& scene) {
    return scene.test_case.empty() ? nullptr : &table_5_1[scene.test_case[0] - 'A'];
}

Json optional_json(const std::optional<double>& v) { return v ? Json(*v) : Json(nullptr); }

std::string exact_cell(const std::optional<double>& v) { return v ? fmt::format("{}", *v) : ""; }

// "" of nothing special, else in quotes, doubled inside.
std::string csv_cell(const std::string& text) {
    if (text.find_first_of(",\"\n") == std::string::npos) return text;
    std::string quoted = "\"";
    for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
    return quoted + "\"";
}

Json pictures_json(const VrsmPictures& p) {
    Json crops = Json::array();
    for (const glm::ivec4& c : p.crops) crops.push_back({c.x, c.y, c.z, c.w});
    return {{"white", p.white},
            {"difference_gain", vrsm_difference_gain},
            {"error_swing", vrsm_error_swing},
            {"crops", crops}};
}

// One table as a terminal shows it: a line a row, standard errors behind +-, the thesis' numbers in parentheses.
std::string table_text(const std::vector<VrsmNumber>& numbers, const std::string& table,
                       const std::vector<std::string>& quantities) {
    std::vector<Column> columns = {{"scene"}, {"row"}};
    for (const std::string& q : quantities) columns.push_back({q, Align::right});
    std::vector<std::vector<std::string>> rows;
    for (const VrsmNumber& n : numbers) {
        if (n.table != table) continue;
        if (rows.empty() || rows.back()[0] != n.scene || rows.back()[1] != n.row)
            rows.push_back({n.scene, n.row}), rows.back().resize(columns.size());
        for (std::size_t q = 0; q < quantities.size(); ++q) {
            if (quantities[q] == n.quantity)
                rows.back()[q + 2] = value_text(n.value, n.unit) + (n.thesis ? fmt::format(" ({:g})", *n.thesis) : "");
            if (quantities[q] + error_suffix == n.quantity && n.value)
                rows.back()[q + 2] += " +- " + value_text(n.value, n.unit);
        }
    }
    return rows.empty() ? "" : format_table(columns, rows) + "\n";
}

// What a setting costs: time, or where nothing was timed samples of a point.
std::string cost_name(const Vrsm& result) { return result.request.times ? "time" : "samples"; }

std::string beside_text(const Vrsm& result, const VrsmBeyond& b, const VrsmBeyond& thesis) {
    const VrsmEstimate rms = relative_rms(b, thesis);
    return fmt::format("{}: {:.1f} % of the {}, {} % of the rms", vrsm_row(b), 100 * b.cost(thesis), cost_name(result),
                       estimate_text(rms));
}

std::string beyond_text(const Vrsm& result) {
    std::string text;
    const std::string cost = cost_name(result);
    for (const VrsmScene& s : result.scenes) {
        bool any = false;
        for (const VrsmBeyond& b : s.beyond) {
            if (b.winner)
                text += fmt::format("{}: VRSM's error by the least {}: {}\n", s.name, cost, beside_text(result, b, s.beyond[0]));
            if (b.least_rms)
                text += fmt::format("{}: least error by VRSM's {}: {}\n", s.name, cost, beside_text(result, b, s.beyond[0]));
            any = any || b.least_rms;
        }
        if (!any && !s.beyond.empty()) text += fmt::format("{}: least error by VRSM's {}: not told apart\n", s.name, cost);
    }
    if (const std::optional<std::size_t> winner = vrsm_winner(result)) {
        const std::vector<VrsmBeyond>& first = result.scenes.front().beyond;
        double most = 0;
        for (const VrsmScene& s : result.scenes) most = std::max(most, s.beyond[*winner].cost(s.beyond.front()));
        text += fmt::format("VRSM's error on every scene by the least {}: {}: at most {:.1f} % of it\n", cost,
                            vrsm_row(first[*winner]), 100 * most);
    }
    return text;
}

// "atrium: least rms: frame, algorithm_2, S = 5: 54.5 +- 0.2 %", or which rows are not told apart.
std::string least_text(const std::string& scene, const std::string& of, const std::vector<const VrsmErrors*>& rows) {
    std::string text;
    for (const VrsmErrors* row : rows) {
        const std::string here = fmt::format("{}: {} %", vrsm_row(*row), estimate_text(row->rms()));
        if (row->best) return fmt::format("{}: least rms{}: {}\n", scene, of, here);
        if (row->tied) text += (text.empty() ? "" : "; ") + here + (row->noisy() ? " (near the truth's noise)" : "");
    }
    return text.empty() ? "" : fmt::format("{}: least rms{}: not told apart: {}\n", scene, of, text);
}

std::string least_texts(const VrsmScene& s) {
    std::string text;
    for (const bool chain : {false, true}) {
        std::vector<const VrsmErrors*> rows;
        for (const VrsmErrors& e : s.errors)
            if (e.chain == chain) rows.push_back(&e);
        text += least_text(s.name, "", rows);
        for (const auto visibility : {rsm::Visibility::none, rsm::Visibility::algorithm_2, rsm::Visibility::algorithm_6}) {
            rows.clear();
            for (const VrsmErrors& e : s.spacing)
                if (e.chain == chain && e.visibility == visibility) rows.push_back(&e);
            text += least_text(s.name, " by spacing", rows);
        }
    }
    return text;
}

Json seeds_json(const VrsmScene& scene) {
    Json all = Json::array();
    auto add = [&](const char* table, const std::string& row, const std::vector<SignedErrors>& seeds) {
        Json one = {{"table", table}, {"row", row}};
        for (const auto& [name, quantity] : {std::pair("rms", &SignedErrors::rms), {"mean error", &SignedErrors::mean_error},
                                             {"removed", &SignedErrors::removed}, {"leaked", &SignedErrors::leaked}}) {
            Json values = Json::array();
            for (const SignedErrors& e : seeds) values.push_back(optional_json(percent(e.*quantity)));
            one[name] = values;
        }
        all.push_back(one);
    };
    for (const VrsmErrors& e : scene.errors) add("errors", vrsm_row(e), e.seeds);
    for (const VrsmErrors& e : scene.spacing) add("spacing", vrsm_row(e), e.seeds);
    for (const VrsmBeyond& b : scene.beyond) add("beyond", vrsm_row(b), b.seeds);
    return all;
}

}  // namespace

std::string vrsm_row(const VrsmErrors& e) {
    static const char* const spacings[] = {"uniform", "quadratic", "geometric"};
    std::string row = e.chain ? "frame, " : "gather, ";
    row += e.visibility == rsm::Visibility::none
               ? "none"
               : fmt::format("algorithm_{}, S = {}", e.visibility == rsm::Visibility::algorithm_2 ? 2 : 6, e.slots);
    return e.spacing ? row + ", " + spacings[int(*e.spacing)] : row;
}

std::string vrsm_row(const VrsmBeyond& b) {
    return b.sets.empty() ? "VRSM" : fmt::format("{}", fmt::join(b.sets, " "));
}

std::vector<VrsmNumber> vrsm_numbers(const Vrsm& result) {
    Numbers n;
    for (const VrsmScene& s : result.scenes) {
        if (s.times.empty()) continue;
        n.at("5.1", s.name, s.test_case.empty() ? "half" : "half, test case " + s.test_case);
        n.add_pair(s.times.at(0), s.times.at(1), printed_of(s));
    }
    if (!result.scenes.empty() && !result.scenes.front().times.empty()) {
        const VrsmScene& first = result.scenes.front();
        const bool printed = first.test_case == "A";
        for (std::size_t i = 0; i + 1 < first.times.size(); i += 2) {
            n.at("5.2", first.name, first.times[i].half ? "half" : "full");
            n.add_pair(first.times[i], first.times[i + 1], printed ? &table_5_2[i / 2] : nullptr);
            // "Nearly three times" (VRSM 4.4).
            auto over_half = [&](std::size_t t) { return median(first.times[i + t].frame_ms) / median(first.times[t].frame_ms); };
            auto thesis = [&](double Printed::*value) {
                return printed ? std::optional(table_5_2[i / 2].*value / table_5_2[0].*value) : std::nullopt;
            };
            n.add("over half, without", "", finite(over_half(0)), thesis(&Printed::without));
            n.add("over half, with", "", finite(over_half(1)), thesis(&Printed::with));
        }
        n.at("5.3", first.name, "");
        n.add_passes(first.times.at(1), printed);
    }
    for (const VrsmScene& s : result.scenes)
        for (const VrsmErrors& e : s.errors) {
            n.at("errors", s.name, vrsm_row(e));
            n.add_errors(e);
        }
    for (const VrsmScene& s : result.scenes)
        for (const VrsmErrors& e : s.spacing) {
            n.at("spacing", s.name, vrsm_row(e));
            n.add_errors(e);
        }
    for (const VrsmScene& s : result.scenes)
        for (const VrsmBeyond& b : s.beyond) {
            n.at("beyond", s.name, vrsm_row(b));
            n.add_beyond(b, s.beyond.front());
        }
    const std::optional<std::size_t> winner = vrsm_winner(result);
    for (std::size_t i = 0; !result.scenes.empty() && i < result.scenes.front().beyond.size(); ++i) {
        n.at("beyond all", "", vrsm_row(result.scenes.front().beyond[i]));
        n.add_worst(result, i, winner == i);
    }
    return n.all;
}

std::string vrsm_csv(const std::vector<VrsmNumber>& numbers) {
    std::string text = "table,scene,row,quantity,unit,value,thesis\n";
    for (const VrsmNumber& n : numbers)
        text += fmt::format("{},{},{},{},{},{},{}\n", n.table, csv_cell(n.scene), csv_cell(n.row), csv_cell(n.quantity),
                            n.unit, exact_cell(n.value), exact_cell(n.thesis));
    return text;
}

Json vrsm_json(const Vrsm& result, const std::vector<VrsmNumber>& numbers) {
    Json scenes = Json::array();
    for (const VrsmScene& s : result.scenes) {
        Json times = Json::array();
        for (const VrsmTimes& t : s.times) {
            Json passes = Json::object();
            for (std::size_t p = 0; p < vrsm_passes.size(); ++p) passes[vrsm_passes[p]] = t.pass_ms[p];
            times.push_back({{"resolution", t.half ? "half" : "full"},
                             {"visibility", t.visibility},
                             {"frame_ms", t.frame_ms},
                             {"pass_ms", passes}});
        }
        Json beyond = Json::array();
        for (const VrsmBeyond& b : s.beyond)
            beyond.push_back({{"row", vrsm_row(b)}, {"family", b.family}, {"sets", b.sets}, {"ms", b.ms}});
        scenes.push_back({{"name", s.name},
                          {"test_case", s.test_case.empty() ? Json(nullptr) : Json(s.test_case)},
                          {"triangles", s.triangles},
                          {"size", {s.size.x, s.size.y}},
                          {"settings", s.settings},
                          {"times", times},
                          {"beyond", beyond},
                          {"by_seed", seeds_json(s)},
                          {"truth", s.truth},
                          {"truth_seconds", s.truth_seconds},
                          {"pictures", pictures_json(s.pictures)}});
    }
    Json list = Json::array();
    for (const VrsmNumber& n : numbers)
        list.push_back({{"table", n.table},
                        {"scene", n.scene},
                        {"row", n.row},
                        {"quantity", n.quantity},
                        {"unit", n.unit},
                        {"value", optional_json(n.value)},
                        {"thesis", optional_json(n.thesis)}});
    auto load = [](double v) { return std::isfinite(v) ? Json(v) : Json(nullptr); };
    return {{"isa", result.isa},
            {"processor", result.processor},
            {"threads", result.threads},
            {"seeds", result.request.seeds},
            {"repeats", result.request.times ? result.request.repeats : 0},
            {"load_before", load(result.load_before)},
            {"load_after", load(result.load_after)},
            {"scenes", scenes},
            {"numbers", list}};
}

std::string value_text(const std::optional<double>& value, const std::string& unit) {
    if (!value) return "undefined";
    if (unit == "ms") return *value < 100 ? fmt::format("{:.3g}", *value) : fmt::format("{:.0f}", *value);
    if (unit == "%") return fmt::format("{:.1f}", *value);
    return fmt::format("{:g}", *value);
}

std::string estimate_text(const VrsmEstimate& e) {
    return value_text(percent(e.mean), "%") + (e.error ? fmt::format(" +- {}", value_text(percent(e.error), "%")) : "");
}

std::string vrsm_text(const Vrsm& result, const std::vector<VrsmNumber>& numbers) {
    std::string text;
    if (result.request.times) {
        const std::vector<std::string> pairs = {"without", "with", "overhead", "overhead by pairs", "fastest without",
                                                "fastest with", "overhead of the fastest", "sampling overhead"};
        text += "in parentheses what VRSM prints of a GPU of 2009\n\n";
        text += "table 5.1: frames without and with visibility, ms; medians\n" + table_text(numbers, "5.1", pairs);
        std::vector<std::string> by_resolution = pairs;
        by_resolution.insert(by_resolution.end(), {"over half, without", "over half, with"});
        text += "table 5.2: by resolution of the indirect light, ms\n" + table_text(numbers, "5.2", by_resolution);
        text += "table 5.3: by pass, with visibility\n" + table_text(numbers, "5.3", {"time", "share"});
    }
    const std::vector<std::string> errors = {"mean error", "rms",     "noise",  "too dark",
                                             "too bright", "removed", "leaked", "leak stopped"};
    text += fmt::format("irradiance against texels with a shadow ray each; % of its mean, of the points or of its energy; mean of "
                        "{} seed{} +- its standard error\n", result.request.seeds, result.request.seeds == 1 ? "" : "s");
    text += table_text(numbers, "errors", errors);
    text += "the same by spacing of the steps along a path\n" + table_text(numbers, "spacing", errors);
    for (const VrsmScene& s : result.scenes) text += least_texts(s);
    return text + beyond_text(result);
}

}  // namespace plumb::cli
