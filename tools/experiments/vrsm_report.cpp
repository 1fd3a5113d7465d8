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

    void add_errors(const SignedErrors& e) {
        add("mean error", "%", percent(e.mean_error));
        add("rms", "%", percent(e.rms));
        add("noise", "%", percent(e.noise));
        add("too dark", "%", percent(e.too_dark));
        add("too bright", "%", percent(e.too_bright));
        add("removed", "%", percent(e.removed));
        add("leaked", "%", percent(e.leaked));
        add("no number", "pixels", double(e.nonfinite));
    }

    void add_beyond(const VrsmBeyond& b, const VrsmBeyond& thesis) {
        add("samples", "", b.samples.x * b.samples.y);
        add("time", "ms", finite(median(b.ms)));
        add("relative time", "%", finite(100 * b.relative_time));
        add("rms", "%", percent(b.errors.rms));
        add("relative rms", "%", percent(relative_rms(b, thesis)));
        add("mean error", "%", percent(b.errors.mean_error));
        add("removed", "%", percent(b.errors.removed));
        add("leaked", "%", percent(b.errors.leaked));
        add("winner", "", double(b.winner));
        add("least rms", "", double(b.least_rms));
    }

    // The setting on the scene where it is worst.
    void add_worst(const Vrsm& result, std::size_t candidate, bool winner) {
        double time = 0;
        std::optional<double> rms = 0;
        for (const VrsmScene& s : result.scenes) {
            const std::optional<double> here = relative_rms(s.beyond.at(candidate), s.beyond.front());
            rms = rms && here ? std::optional(std::max(*rms, *here)) : std::nullopt;
            time = std::max(time, s.beyond[candidate].relative_time);
        }
        add("largest relative time", "%", finite(100 * time));
        add("largest relative rms", "%", percent(rms));
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

// One table as a terminal shows it: a line a row, the thesis' numbers in parentheses.
std::string table_text(const std::vector<VrsmNumber>& numbers, const std::string& table,
                       const std::vector<std::string>& quantities) {
    std::vector<Column> columns = {{"scene"}, {"row"}};
    for (const std::string& q : quantities) columns.push_back({q, Align::right});
    std::vector<std::vector<std::string>> rows;
    for (const VrsmNumber& n : numbers) {
        if (n.table != table) continue;
        if (rows.empty() || rows.back()[0] != n.scene || rows.back()[1] != n.row)
            rows.push_back({n.scene, n.row}), rows.back().resize(columns.size());
        for (std::size_t q = 0; q < quantities.size(); ++q)
            if (quantities[q] == n.quantity)
                rows.back()[q + 2] = value_text(n.value, n.unit) + (n.thesis ? fmt::format(" ({:g})", *n.thesis) : "");
    }
    return rows.empty() ? "" : format_table(columns, rows) + "\n";
}

std::string beside_text(const VrsmBeyond& b, const VrsmBeyond& thesis) {
    const std::optional<double> rms = relative_rms(b, thesis);
    return fmt::format("{}: {:.1f} % of the time, {} % of the rms", vrsm_row(b), 100 * b.relative_time,
                       rms ? fmt::format("{:.1f}", 100 * *rms) : "undefined");
}

std::string beyond_text(const Vrsm& result) {
    std::string text;
    for (const VrsmScene& s : result.scenes)
        for (const VrsmBeyond& b : s.beyond) {
            if (b.winner)
                text += fmt::format("{}: VRSM's error in least time: {}\n", s.name, beside_text(b, s.beyond[0]));
            if (b.least_rms)
                text += fmt::format("{}: least error in VRSM's time: {}\n", s.name, beside_text(b, s.beyond[0]));
        }
    if (const std::optional<std::size_t> winner = vrsm_winner(result)) {
        const std::vector<VrsmBeyond>& first = result.scenes.front().beyond;
        double time = 0;
        for (const VrsmScene& s : result.scenes) time = std::max(time, s.beyond[*winner].relative_time);
        text += fmt::format("VRSM's error on every scene in least time: {}: at most {:.1f} % of it\n",
                            vrsm_row(first[*winner]), 100 * time);
    }
    return text;
}

}  // namespace

std::string vrsm_row(const VrsmErrors& e) {
    const std::string kind = e.chain ? "frame" : "gather";
    if (e.visibility == rsm::Visibility::none) return kind + ", none";
    return fmt::format("{}, algorithm_{}, S = {}", kind, e.visibility == rsm::Visibility::algorithm_2 ? 2 : 6, e.slots);
}

std::string vrsm_row(const VrsmBeyond& b) {
    return b.sets.empty() ? "VRSM" : fmt::format("{}", fmt::join(b.sets, " "));
}

std::vector<VrsmNumber> vrsm_numbers(const Vrsm& result) {
    Numbers n;
    for (const VrsmScene& s : result.scenes) {
        n.at("5.1", s.name, s.test_case.empty() ? "half" : "half, test case " + s.test_case);
        n.add_pair(s.times.at(0), s.times.at(1), printed_of(s));
    }
    if (!result.scenes.empty()) {
        const VrsmScene& first = result.scenes.front();
        const bool printed = first.test_case == "A";
        for (std::size_t i = 0; i + 1 < first.times.size(); i += 2) {
            n.at("5.2", first.name, first.times[i].half ? "half" : "full");
            n.add_pair(first.times[i], first.times[i + 1], printed ? &table_5_2[i / 2] : nullptr);
        }
        n.at("5.3", first.name, "");
        n.add_passes(first.times.at(1), printed);
    }
    for (const VrsmScene& s : result.scenes)
        for (const VrsmErrors& e : s.errors) {
            n.at("errors", s.name, vrsm_row(e));
            n.add_errors(e.errors);
            n.add("best", "", double(e.best));
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
            {"repeats", result.request.repeats},
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

std::string vrsm_text(const Vrsm& result, const std::vector<VrsmNumber>& numbers) {
    std::string text = "in parentheses what VRSM prints of a GPU of 2009\n\n";
    text += "table 5.1: frames without and with visibility, ms; medians\n" +
            table_text(numbers, "5.1",
                       {"without", "with", "overhead", "overhead by pairs", "fastest without", "fastest with",
                        "overhead of the fastest", "sampling overhead"});
    text += "table 5.2: by resolution of the indirect light, ms\n" +
            table_text(numbers, "5.2",
                       {"without", "with", "overhead", "overhead by pairs", "fastest without", "fastest with",
                        "overhead of the fastest", "sampling overhead"});
    text += "table 5.3: by pass, with visibility\n" + table_text(numbers, "5.3", {"time", "share"});
    text +=
        "irradiance against every texel with a shadow ray; % of its mean, of the points or of its energy\n" +
        table_text(numbers, "errors", {"mean error", "rms", "noise", "too dark", "too bright", "removed", "leaked"});
    for (const VrsmScene& s : result.scenes)
        for (const VrsmErrors& e : s.errors)
            if (e.best)
                text +=
                    fmt::format("{}: least rms: {}, {} %\n", s.name, vrsm_row(e), value_text(100 * *e.errors.rms, "%"));
    return text + beyond_text(result);
}

}  // namespace plumb::cli
