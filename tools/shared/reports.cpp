#include "tools/shared/reports.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/content_hash.h"
#include "core/parallel.h"
#include "gi/frame/mirrors.h"
#include "gi/parity/stages.h"
#include "gi/uniform_words.h"
#include "tools/shared/table.h"

namespace plumb::cli {

namespace {

// JSON has neither NaN nor infinity.
Json number_json(std::optional<double> value) { return value && std::isfinite(*value) ? Json(*value) : Json(nullptr); }

// The shortest decimal that reads back as the same float: 0.3, not 0.30000001192092896.
Json float_json(float value) { return std::isfinite(value) ? Json::parse(fmt::format("{}", value)) : Json(nullptr); }

Json value_json(const Field& f) {
    if (!f.choices.empty()) return f.choices.at(*std::get<int*>(f.value));
    if (auto p = std::get_if<int*>(&f.value)) return **p;
    if (auto p = std::get_if<float*>(&f.value)) return float_json(**p);
    if (auto p = std::get_if<bool*>(&f.value)) return **p;
    if (auto p = std::get_if<std::string*>(&f.value)) return **p;
    const glm::vec3& v = *std::get<glm::vec3*>(f.value);
    return {float_json(v.x), float_json(v.y), float_json(v.z)};
}

std::string number_text(std::optional<double> value, const char* unit = "") {
    if (!value) return "undefined";
    if (std::isinf(*value)) return fmt::format("infinite{}", unit);
    return fmt::format("{:.6g}{}", *value, unit);
}

}  // namespace

std::string json_text(const Json& json) { return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n"; }

Json settings_json(const frame::Settings& settings) {
    frame::Settings s = settings;
    Json json;
    json["method"] = frame::method_name(s.method);
    json["layout"] = s.layout.name;
    json["seed"] = s.seed;
    json["pruning"] = s.pruning;
    for (const std::string& table : frame::method_tables()) {
        Json values = Json::object();
        for (const Field& f : frame::table_fields(s, table, table)) values[f.name] = value_json(f);
        json[table == "layout" ? "layout_formats" : table] = values;
    }
    if (s.rsm.own) {
        const std::vector<glm::dvec3>& rows = s.rsm.own->rows;
        json["rsm"]["pattern_hash"] = hash_text(content_hash(rows.data(), rows.size() * sizeof(rows[0])));
    }
    return json;
}

namespace {

Json parts_json(const std::vector<frame::LeftOut>& parts) {
    Json json = Json::array();
    for (const frame::LeftOut& part : parts)
        json.push_back({{"rule", part.rule}, {"reason", part.reason}, {"saved_ms", part.saved_ms}});
    return json;
}

// Why a stage runs, or does not; and which parts of it do not, where the reason has not said so.
template <class Stage>
std::string why_text(const Stage& s) {
    std::string text = s.needed ? s.reason : "left out: " + s.reason;
    for (const frame::LeftOut& part : s.parts)
        if (s.reason.find(part.reason) == std::string::npos) text += "; " + part.reason;
    return text;
}

// The rules that left something out, in their order.
template <class Stage>
std::string rules_text(const Stage& s) {
    std::string text = s.rule;
    for (const frame::LeftOut& part : s.parts) text += (text.empty() ? "" : ", ") + part.rule;
    return text;
}

std::string saved_text(double ms) { return ms > 0 ? milliseconds_text(ms) : ""; }

}  // namespace

Json stage_runs_json(const std::vector<frame::StageRun>& stages) {
    Json json = Json::array();
    for (const frame::StageRun& s : stages) {
        json.push_back({{"name", s.label},
                        {"needed", s.needed},
                        {"kept", s.kept},
                        {"reason", s.reason},
                        {"rule", s.rule},
                        {"ms", s.ms},
                        {"saved_ms", s.saved_ms},
                        {"parts", parts_json(s.parts)},
                        {"bytes", s.bytes},
                        {"reads", s.reads}});
        if (s.key) json.back()["key"] = hash_text(s.key);
    }
    return json;
}

void add_times(const RunTimes& times, Json& json) {
    json["read_ms"] = times.read_ms, json["render_ms"] = times.render_ms;
    json["write_ms"] = times.write_ms, json["total_ms"] = times.total_ms;
}

std::string times_text(const RunTimes& times) {
    return fmt::format("in {} ms: {} reading, {} rendering, {} writing", milliseconds_text(times.total_ms),
                       milliseconds_text(times.read_ms), milliseconds_text(times.render_ms),
                       milliseconds_text(times.write_ms));
}

void add_left_out(const Scene& scene, const frame::Settings& settings, Json& json) {
    const std::string left_out = frame::lobes_left_out(scene, settings);
    if (!left_out.empty()) json["left_out"] = left_out;
}

Json run_json(const RunReport& run) {
    Json kernels = Json::object();
    for (const frame::StageRun& s : run.stages)
        if (s.needed) kernels[s.label] = isa_name(s.isa);
    Json json = {{"version", run_version},
                 {"scene", run.scene.name},
                 {"notes", run.scene.notes},
                 {"settings", settings_json(run.settings)},
                 {"isa", isa_name(run.options.isa)},
                 {"kernels", kernels},
                 {"threads", thread_count(run.options.threads)},
                 {"stages", stage_runs_json(run.stages)}};
    add_times(run.times, json);
    json["peak_bytes"] = run.peak_bytes;
    add_left_out(run.scene, run.settings, json);
    if (!run.truth.is_null()) json["truth"] = run.truth;
    if (!run.radiosity.is_null()) json["radiosity"] = run.radiosity;
    return json;
}

std::string run_text(const RunReport& run) {
    std::vector<std::vector<std::string>> rows;
    rows.push_back({"read scene", milliseconds_text(run.times.read_ms), "-", ""});
    for (const frame::StageRun& s : run.stages) {
        rows.push_back({s.label, s.needed ? milliseconds_text(s.ms) : "-", s.needed ? megabytes_text(s.bytes) : "-",
                        why_text(s)});
    }
    rows.push_back({"write files", milliseconds_text(run.times.write_ms), "-", ""});
    const int threads = thread_count(run.options.threads);
    return format_table({{"stage"}, {"ms", Align::right}, {"MB", Align::right}, {"why"}}, rows) +
           fmt::format("\n{} x {} pixels {}; by {} on {} thread{}, at most {} MB of memory\n",
                       run.scene.frame_size.x, run.scene.frame_size.y, times_text(run.times),
                       isa_name(run.options.isa), threads, threads == 1 ? "" : "s", megabytes_text(run.peak_bytes));
}

Json plan_json(const Scene& scene, const frame::Settings& settings, const frame::Plan& plan) {
    Json stages = Json::array();
    double expected_ms = 0, saved_ms = 0;
    for (const frame::PlannedStage& s : plan.stages) {
        stages.push_back({{"name", s.label},
                          {"needed", s.needed},
                          {"reason", s.reason},
                          {"rule", s.rule},
                          {"work", s.work},
                          {"work_unit", s.work_unit},
                          {"expected_ms", s.expected_ms},
                          {"saved_ms", s.saved_ms},
                          {"parts", parts_json(s.parts)}});
        expected_ms += s.expected_ms, saved_ms += s.saved_ms;
    }
    Json json = {{"scene", scene.name},
                 {"settings", settings_json(settings)},
                 {"stages", stages},
                 {"expected_ms", expected_ms},
                 {"saved_ms", saved_ms}};
    add_left_out(scene, settings, json);
    return json;
}

std::string plan_text(const frame::Plan& plan) {
    std::vector<std::vector<std::string>> rows;
    double expected_ms = 0, saved_ms = 0;
    for (const frame::PlannedStage& s : plan.stages) {
        rows.push_back({s.label, s.needed ? fmt::format("{:.4g}", s.work * 1e-6) : "-", s.needed ? s.work_unit : "",
                        s.needed ? milliseconds_text(s.expected_ms) : "-", saved_text(s.saved_ms), rules_text(s),
                        why_text(s)});
        expected_ms += s.expected_ms, saved_ms += s.saved_ms;
    }
    return format_table({{"stage"}, {"work", Align::right}, {"millions of"}, {"ms", Align::right},
                         {"saves", Align::right}, {"rule"}, {"why"}},
                        rows) +
           fmt::format("\nabout {} ms in all, {} ms left out; ms are for one core with AVX-512, an order of magnitude\n",
                       milliseconds_text(expected_ms), milliseconds_text(saved_ms));
}

Json rules_json(const std::vector<frame::Rule>& rules) {
    Json json = Json::array();
    for (const frame::Rule& r : rules)
        json.push_back({{"name", r.name},
                        {"stages", r.stages},
                        {"part", r.part},
                        {"reason", r.reason},
                        {"asked", r.holds ? "plan" : "run"}});
    return json;
}

std::string rules_text(const std::vector<frame::Rule>& rules) {
    std::vector<std::vector<std::string>> rows;
    for (const frame::Rule& r : rules)
        rows.push_back({r.name, r.holds ? "plan" : "run", r.part.empty() ? "all" : r.part,
                        fmt::format("{}", fmt::join(r.stages, " ")), r.reason});
    return format_table({{"rule"}, {"asked"}, {"leaves out"}, {"of"}, {"where"}}, rows);
}

Json compare_json(const compare::Report& r) {
    return {{"mean_error", number_json(r.mean_error)},
            {"rmse", number_json(r.rmse)},
            {"rel_mse", number_json(r.rel_mse)},
            {"psnr", number_json(r.psnr)},
            {"ssim", number_json(r.ssim)},
            {"flip", number_json(r.flip)},
            {"pearson", number_json(r.pearson)},
            {"max_ulp", r.max_ulp},
            {"differing", number_json(r.differing)},
            {"pixels", r.pixels},
            {"nonfinite", r.nonfinite},
            {"equal", r.equal}};
}

std::string compare_text(const compare::Report& r) {
    std::vector<std::vector<std::string>> rows = {
        {"mean error", number_text(r.mean_error)},
        {"RMSE", number_text(r.rmse)},
        {"relMSE", number_text(r.rel_mse)},
        {"PSNR", number_text(r.psnr, " dB")},
        {"SSIM", number_text(r.ssim)},
        {"FLIP", number_text(r.flip)},
        {"Pearson", number_text(r.pearson)},
        {"max ULP", r.max_ulp == compare::saturated_ulp ? "undefined" : fmt::format("{}", r.max_ulp)},
        {"differing", fmt::format("{:.6g} % of {} pixels", 100 * r.differing, r.pixels)},
        {"not finite", fmt::format("{} pixels", r.nonfinite)},
    };
    if (r.worst) {
        rows.push_back({"worst", fmt::format("pixel {},{} {}: A {}, B {}", r.worst->x, r.worst->y, r.worst->channel,
                                             exact_text(r.worst->a), exact_text(r.worst->b))});
    }
    return format_table({{""}, {""}}, rows);
}

// The members of a stage's block; none of a stage without a twin.
template <class Each>
void each_uniform(const StageInfo& stage, Each each) {
    const std::vector<StageBinding>& all = parity::bindings();
    const auto binding = std::find_if(all.begin(), all.end(), [&](const StageBinding& b) { return b.info.name == stage.name; });
    if (binding == all.end()) return;
    for (const UniformMember& m : binding->uniforms) {
        const UniformWords* words = words_of(*binding, m.name);
        each(m, words ? *words : UniformWords{});
    }
}

Json uniforms_json(const StageInfo& stage) {
    Json json = Json::array();
    each_uniform(stage, [&](const UniformMember& m, const UniformWords& words) {
        json.push_back({{"name", m.name}, {"type", m.type}, {"unit", words.unit}, {"meaning", words.meaning},
                        {"harmless", words.harmless}});
    });
    return json;
}

Json stages_json(const std::vector<StageInfo>& stages) {
    auto ports_json = [](const std::vector<Port>& ports) {
        Json json = Json::array();
        for (const Port& p : ports)
            json.push_back({{"name", p.name}, {"type", p.type}, {"unit", p.unit}, {"meaning", p.meaning}});
        return json;
    };
    Json json = Json::array();
    for (const StageInfo& s : stages) {
        Json params = Json::array();
        for (const ParamInfo& p : s.params) {
            params.push_back({{"name", p.name},
                              {"type", p.type},
                              {"default", p.default_value},
                              {"range", p.range},
                              {"unit", p.unit},
                              {"meaning", p.meaning}});
        }
        json.push_back({{"name", s.name},
                        {"source", s.source},
                        {"inputs", ports_json(s.inputs)},
                        {"outputs", ports_json(s.outputs)},
                        {"params", params},
                        {"uniforms", uniforms_json(s)},
                        {"twin", s.twin},
                        {"budget", {{"c", s.budget.c}, {"reason", s.budget.reason}}}});
    }
    return json;
}

std::string stages_text(const std::vector<StageInfo>& stages) {
    std::string text;
    for (const StageInfo& s : stages) {
        text += fmt::format("{}{}\n  {}\n  twin {}; error at most {} eps x condition{}\n", text.empty() ? "" : "\n",
                            s.name, s.source, s.twin.empty() ? "none" : s.twin, s.budget.c,
                            s.budget.reason.empty() ? "" : " (" + s.budget.reason + ")");
        auto add_ports = [&](const char* kind, const std::vector<Port>& ports) {
            std::vector<std::vector<std::string>> rows;
            for (const Port& p : ports) rows.push_back({p.name, p.type, p.unit, p.meaning});
            if (!rows.empty()) text += fmt::format("  {}\n", kind) + format_table({{}, {}, {}, {}}, rows, 4);
        };
        add_ports("inputs", s.inputs);
        add_ports("outputs", s.outputs);
        std::vector<std::vector<std::string>> rows;
        for (const ParamInfo& p : s.params) rows.push_back({p.name, p.default_value, p.range, p.unit, p.meaning});
        if (!rows.empty())
            text += "  parameters\n" + format_table({{"name"}, {"default"}, {"range"}, {"unit"}, {"meaning"}}, rows, 4);
        rows.clear();
        each_uniform(s, [&](const UniformMember& m, const UniformWords& words) {
            rows.push_back({m.name, m.type, words.unit, words.meaning, words.harmless});
        });
        if (!rows.empty())
            text += "  uniforms, in the order of the block\n" +
                    format_table({{"name"}, {"type"}, {"unit"}, {"meaning"}, {"harmless"}}, rows, 4);
    }
    return text;
}

Json components_json(const std::vector<double>& value) {
    Json components = Json::array();
    for (double component : value) components.push_back(number_json(component));
    return components.size() == 1 ? components[0] : components;
}

Json explain_json(const frame::Explanation& e) {
    Json values = Json::array();
    for (const TapValue& v : e.values) {
        Json value;
        value["name"] = v.name;
        if (v.sample >= 0) value["sample"] = v.sample;
        value["value"] = components_json(v.value);
        value["equation"] = v.equation;
        values.push_back(std::move(value));
    }
    return {{"stage", e.stage}, {"pixel", {e.pixel.x, e.pixel.y}}, {"values", std::move(values)}};
}

std::string explain_text(const frame::Explanation& e) {
    // The column of samples is there where the stage has any.
    bool samples = false;
    std::size_t components = 1;
    for (const TapValue& v : e.values) {
        samples |= v.sample >= 0;
        components = std::max(components, v.value.size());
    }
    std::vector<Column> columns = {{"name"}, {"value"}};
    columns.resize(1 + components + 1);
    columns.back() = {"equation"};
    if (samples) columns.insert(columns.begin(), {"sample", Align::right});
    std::vector<std::vector<std::string>> rows;
    for (const TapValue& v : e.values) {
        std::vector<std::string> row;
        if (samples) row.push_back(v.sample >= 0 ? fmt::format("{}", v.sample) : "");
        row.push_back(v.name);
        for (std::size_t c = 0; c < components; ++c) row.push_back(c < v.value.size() ? exact_text(v.value[c]) : "");
        row.push_back(v.equation);
        rows.push_back(std::move(row));
    }
    return fmt::format("{} at {},{}\n", e.stage, e.pixel.x, e.pixel.y) + format_table(columns, rows);
}

}  // namespace plumb::cli
