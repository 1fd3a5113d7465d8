// Writes a sweep as JSON, CSV and text, and reads the JSON again. The keys are a contract.
#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/content_hash.h"
#include "core/error.h"
#include "io/file.h"
#include "tools/shared/sweep.h"
#include "tools/shared/table.h"

namespace plumb::cli {

namespace {

// JSON has neither NaN nor infinity.
Json number_json(double v) { return std::isfinite(v) ? Json(v) : Json(nullptr); }

Json value_json(const FieldValue& value) {
    if (auto p = std::get_if<double>(&value)) return *p;
    if (auto p = std::get_if<bool>(&value)) return *p;
    if (auto p = std::get_if<std::string>(&value)) return *p;
    const glm::vec3& v = std::get<glm::vec3>(value);
    return {v.x, v.y, v.z};
}

Json error_json(const SweepError& e) {
    return {{"rmse", number_json(e.rmse)},
            {"rel_mse", number_json(e.rel_mse)},
            {"mean_error", number_json(e.mean_error)},
            {"standard_error", number_json(e.standard_error)},
            {"below_noise", e.below_noise},
            {"truth_error", number_json(e.truth_error)}};
}

// Reads a JSON value and knows where it stands: "points[3].median_ms".
class Reader {
  public:
    Reader(const Json& json, std::string file, std::string place = "")
        : json_(json), file_(std::move(file)), place_(std::move(place)) {}

    Reader at(const std::string& key) const {
        if (!json_.is_object()) fail("an object");
        const auto value = json_.find(key);
        const std::string place = place_.empty() ? key : place_ + "." + key;
        if (value == json_.end()) Reader(json_, file_, place).fail("a value");
        return {*value, file_, place};
    }
    std::vector<Reader> all() const {
        if (!json_.is_array()) fail("an array");
        std::vector<Reader> parts;
        for (std::size_t i = 0; i < json_.size(); ++i)
            parts.push_back({json_[i], file_, fmt::format("{}[{}]", place_, i)});
        return parts;
    }
    std::string text() const {
        if (!json_.is_string()) fail("a string");
        return json_.get<std::string>();
    }
    bool flag() const {
        if (!json_.is_boolean()) fail("true or false");
        return json_.get<bool>();
    }
    frame::Method method() const { return frame::parse_method(text(), where()); }
    double number() const {
        if (!json_.is_number()) fail("a number");
        return json_.get<double>();
    }
    // Of an error: null stands for what is no number.
    double not_negative() const {
        if (json_.is_null()) return std::numeric_limits<double>::quiet_NaN();
        const double v = number();
        if (v < 0) fail("a number of at least 0");
        return v;
    }
    // Of a time, which is always a number.
    double milliseconds() const {
        if (json_.is_null()) fail("a number");
        return not_negative();
    }
    double above_zero() const {
        const double v = milliseconds();
        if (v == 0) fail("a number above 0");
        return v;
    }
    std::uint64_t whole(std::uint64_t most) const {
        if (!json_.is_number_unsigned() || json_.get<std::uint64_t>() > most)
            fail(fmt::format("a whole number from 0 to {}", most));
        return json_.get<std::uint64_t>();
    }
    std::uint64_t hash() const {
        const std::string digits = text();
        std::uint64_t value = 0;
        if (digits.size() != 16 || digits.find_first_not_of("0123456789abcdef") != std::string::npos)
            fail("16 hexadecimal digits");
        for (char c : digits) value = value << 4 | std::uint64_t(c <= '9' ? c - '0' : c - 'a' + 10);
        return value;
    }
    const Json& json() const { return json_; }
    [[noreturn]] void fail(const std::string& expected) const {
        throw InputError(fmt::format("{}: expected {}", where(), expected));
    }

  private:
    std::string where() const { return file_ + ": " + (place_.empty() ? "the whole" : place_); }

    const Json& json_;
    std::string file_, place_;
};

FieldValue read_value(const Reader& r) {
    const Json& j = r.json();
    if (j.is_boolean()) return j.get<bool>();
    if (j.is_string()) return j.get<std::string>();
    if (j.is_array() && j.size() == 3) {
        const std::vector<Reader> parts = r.all();
        return glm::vec3(float(parts[0].number()), float(parts[1].number()), float(parts[2].number()));
    }
    return r.number();
}

SweepError read_error(const Reader& r) {
    return {r.at("rmse").not_negative(), r.at("rel_mse").not_negative(), r.at("mean_error").not_negative(),
            r.at("standard_error").not_negative(), r.at("below_noise").flag(), r.at("truth_error").not_negative()};
}

constexpr std::uint64_t most_bytes = std::uint64_t(1) << 62, most_int = 2147483647;

SweepPoint read_point(const Reader& r) {
    SweepPoint p;
    p.scene = r.at("scene").text(), p.method = r.at("curve").text(), p.settings = r.at("settings").text();
    p.base = r.at("method").method();
    for (const Reader& c : r.at("changed").all())
        p.changed.push_back({c.at("table").text(), c.at("key").text(), read_value(c.at("value")), ""});
    const Reader runs = r.at("frame_ms");
    for (const Reader& ms : runs.all()) p.frame_ms.push_back(ms.above_zero());
    if (p.frame_ms.empty()) runs.fail("at least one run");
    p.median_ms = r.at("median_ms").above_zero();
    p.low_ms = r.at("low_ms").above_zero(), p.high_ms = r.at("high_ms").above_zero();
    p.stage_ms = r.at("stage_ms").milliseconds();  // 0: no stage is named after the method
    p.peak_bytes = r.at("peak_bytes").whole(most_bytes);
    p.own = read_error(r.at("own")), p.full = read_error(r.at("full"));
    p.pareto = r.at("pareto").flag();
    p.picture_hash = r.at("picture").hash();
    return p;
}

std::string quoted(const std::string& text) {
    std::string result = "\"";
    for (char c : text) result += c == '"' ? "\"\"" : std::string(1, c);
    return result + "\"";
}

std::string number_text(double v) { return std::isfinite(v) ? fmt::format("{:.4g}", v) : "undefined"; }

}  // namespace

Json point_json(const SweepPoint& p) {
    Json changed = Json::array();
    for (const Setting& s : p.changed)
        changed.push_back({{"table", s.table}, {"key", s.key}, {"value", value_json(s.value)}});
    return {{"scene", p.scene},
            {"method", frame::method_name(p.base)},
            {"curve", p.method},
            {"settings", p.settings},
            {"changed", changed},
            {"frame_ms", p.frame_ms},
            {"median_ms", number_json(p.median_ms)},
            {"low_ms", number_json(p.low_ms)},
            {"high_ms", number_json(p.high_ms)},
            {"stage_ms", number_json(p.stage_ms)},
            {"peak_bytes", p.peak_bytes},
            {"own", error_json(p.own)},
            {"full", error_json(p.full)},
            {"pareto", p.pareto},
            {"picture", hash_text(p.picture_hash)}};
}

Json sweep_json(const Sweep& sweep) {
    Json scenes = Json::array(), points = Json::array(), left_out = Json::array();
    for (const SweptScene& s : sweep.scenes)
        scenes.push_back({{"name", s.name},
                          {"width", s.width},
                          {"height", s.height},
                          {"content", hash_text(s.content)},
                          {"truth", hash_text(s.truth)},
                          {"truth_samples", s.samples},
                          {"truth_relative_error", number_json(s.relative_error)}});
    for (const SweepPoint& p : sweep.points) points.push_back(point_json(p));
    for (const LeftOut& l : sweep.left_out)
        left_out.push_back({{"scene", l.scene},
                            {"curve", l.method},
                            {"settings", l.settings},
                            {"reason", l.reason},
                            {"too_long", l.too_long}});
    return {{"isa", sweep.isa},         {"processor", sweep.processor}, {"threads", sweep.threads},
            {"runs", sweep.runs},       {"memory", sweep.memory},       {"scenes", scenes},
            {"points", points},         {"left_out", left_out},         {"notes", sweep.notes}};
}

std::string sweep_csv(const Sweep& sweep) {
    std::string text =
        "scene,method,curve,settings,median_ms,low_ms,high_ms,stage_ms,runs,peak_bytes,own_rmse,own_rel_mse,"
        "own_mean_error,own_standard_error,full_rmse,full_rel_mse,full_mean_error,full_standard_error,pareto,picture\n";
    auto errors = [](const SweepError& e) {
        return fmt::format("{},{},{},{}", e.rmse, e.rel_mse, e.mean_error, e.standard_error);
    };
    for (const SweepPoint& p : sweep.points)
        text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", quoted(p.scene), frame::method_name(p.base),
                            quoted(p.method), quoted(p.settings), p.median_ms, p.low_ms, p.high_ms, p.stage_ms,
                            p.frame_ms.size(), p.peak_bytes, errors(p.own), errors(p.full), p.pareto ? 1 : 0,
                            hash_text(p.picture_hash));
    return text;
}

std::string sweep_text(const Sweep& sweep) {
    std::string text;
    for (const SweptScene& scene : sweep.scenes) {
        std::vector<std::vector<std::string>> rows;
        for (const SweepPoint& p : sweep.points) {
            if (p.scene != scene.name) continue;
            rows.push_back({p.method, p.settings, milliseconds_text(p.median_ms),
                            milliseconds_text(p.low_ms) + " - " + milliseconds_text(p.high_ms),
                            milliseconds_text(p.stage_ms), megabytes_text(p.peak_bytes),
                            number_text(p.own.rmse) + (p.own.below_noise ? " (noise)" : ""),
                            number_text(p.full.rmse) + (p.full.below_noise ? " (noise)" : ""), p.pareto ? "*" : ""});
        }
        text += fmt::format("{}: {} x {} pixels; truth: {} samples, standard error {:.3g} % of the mean\n\n", scene.name,
                            scene.width, scene.height, scene.samples, 100 * scene.relative_error);
        text += format_table({{"curve"},
                              {"settings"},
                              {"ms", Align::right},
                              {"quartiles", Align::right},
                              {"of it stages", Align::right},
                              {"MB", Align::right},
                              {"RMSE, own truth", Align::right},
                              {"RMSE, full", Align::right},
                              {"front"}},
                             rows);
        text += "\n";
    }
    for (const LeftOut& l : sweep.left_out)
        text += fmt::format("left out: {}: {}{}{}: {}\n", l.scene, l.method, l.settings.empty() ? "" : ", ", l.settings,
                            l.reason);
    for (const std::string& note : sweep.notes) text += "note: " + note + "\n";
    text += fmt::format("medians of {} runs in turns by {} on {} thread{}\n", sweep.runs, sweep.isa, sweep.threads,
                        sweep.threads == 1 ? "" : "s");
    return text;
}

Sweep sweep_of(const std::string& text, const std::string& place) {
    Json json;
    try {
        json = Json::parse(text);
    } catch (const Json::parse_error& e) {
        throw InputError(fmt::format("{}: byte {}: no JSON", place, e.byte));
    } catch (const Json::out_of_range&) {
        throw InputError(place + ": a number that is not finite");
    }
    const Reader r(json, place);
    Sweep sweep;
    sweep.isa = r.at("isa").text(), sweep.processor = r.at("processor").text(), sweep.memory = r.at("memory").text();
    sweep.threads = int(r.at("threads").whole(most_int)), sweep.runs = int(r.at("runs").whole(most_int));
    for (const Reader& s : r.at("scenes").all())
        sweep.scenes.push_back({s.at("name").text(), int(s.at("width").whole(most_int)),
                                int(s.at("height").whole(most_int)), s.at("content").hash(), s.at("truth").hash(),
                                int(s.at("truth_samples").whole(most_int)), s.at("truth_relative_error").not_negative()});
    for (const Reader& p : r.at("points").all()) sweep.points.push_back(read_point(p));
    for (const Reader& l : r.at("left_out").all())
        sweep.left_out.push_back(
            {l.at("scene").text(), l.at("curve").text(), l.at("settings").text(), l.at("reason").text(),
             l.at("too_long").flag()});
    for (const Reader& n : r.at("notes").all()) sweep.notes.push_back(n.text());
    return sweep;
}

Sweep read_sweep(const std::string& path) {
    const std::vector<unsigned char> bytes = io::read_bytes(path);
    return sweep_of(std::string(bytes.begin(), bytes.end()), path);
}

}  // namespace plumb::cli
