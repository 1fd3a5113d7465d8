// plumb experiment closed-forms: holds path tracer, ambient occlusion and rsm.all against light whose amount is known.
#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "gi/reference/closed_forms.h"
#include "tools/experiments/experiments.h"
#include "tools/shared/command.h"
#include "tools/shared/reports.h"
#include "tools/shared/table.h"

namespace plumb::cli {

namespace {

using reference::ClosedForm;
using reference::Measured;
using reference::Verdict;

constexpr double max_sigmas = 3;

struct ClosedFormsOptions {
    Common common;
    double error_percent = 0.06;
    std::uint32_t seed = 1;
    std::string only, rays = "native";
};

struct Row {
    ClosedForm form;
    Measured measured;
    Verdict verdict;
};

// One line on a terminal: which case runs.
void show_progress(std::size_t done, std::size_t all, const std::string& name) {
    if (isatty(STDERR_FILENO))
        std::fprintf(stderr, "\r\033[K%s",
                     name.empty() ? "" : fmt::format("{} of {}: {}", done + 1, all, name).c_str());
}

std::vector<Row> measure_all(const ClosedFormsOptions& given) {
    reference::ClosedFormOptions options;
    options.error = given.error_percent / 100;
    options.seed = given.seed;
    options.rays = given.rays == "exact" ? Rays::exact : Rays::native;
    options.run = given.common.run_options();
    std::vector<ClosedForm> forms = reference::closed_forms();
    std::erase_if(forms, [&](const ClosedForm& f) { return f.name.find(given.only) == std::string::npos; });
    if (forms.empty()) throw InputError(fmt::format("--only: no case has \"{}\" in its name", given.only));
    std::vector<Row> rows;
    for (const ClosedForm& form : forms) {
        show_progress(rows.size(), forms.size(), form.name);
        const Measured measured = reference::measure(form, options);
        rows.push_back({form, measured, reference::judge(form, measured, max_sigmas)});
    }
    show_progress(0, 0, "");
    return rows;
}

// Sums up all cases: how many disagree, and the root mean square of the differences in standard errors, 1 where these
// are honest.
struct Summary {
    std::size_t cases = 0, disagreeing = 0, sampled = 0;
    double rms_sigmas = 0, seconds = 0;
};
Summary summarise(const std::vector<Row>& rows) {
    Summary s;
    s.cases = rows.size();
    for (const Row& r : rows) {
        s.disagreeing += !r.verdict.agrees;
        s.seconds += r.measured.seconds;
        if (!reference::is_noisy(r.form, r.measured)) continue;
        ++s.sampled;
        s.rms_sigmas += r.verdict.sigmas * r.verdict.sigmas;
    }
    s.rms_sigmas = s.sampled ? std::sqrt(s.rms_sigmas / double(s.sampled)) : 0;
    return s;
}

Json closed_forms_json(const std::vector<Row>& rows) {
    // JSON knows no NaN: null stands for it.
    auto number = [](double v) { return std::isfinite(v) ? Json(v) : Json(nullptr); };
    Json cases = Json::array();
    for (const Row& r : rows)
        cases.push_back({{"name", r.form.name},
                         {"source", r.form.source},
                         {"unit", r.form.unit},
                         {"expected", r.form.expected},
                         {"got", number(r.measured.got)},
                         {"relative_difference", number(r.verdict.relative)},
                         {"bound", r.form.bound},
                         {"standard_error", number(r.measured.standard_error)},
                         {"sigmas", r.form.statistical ? number(r.verdict.sigmas) : Json(nullptr)},
                         {"samples", r.measured.samples},
                         {"rays", r.measured.rays},
                         {"nonfinite", r.measured.nonfinite},
                         {"seconds", r.measured.seconds},
                         {"agrees", r.verdict.agrees}});
    const Summary s = summarise(rows);
    return {{"cases", cases},
            {"disagreeing", s.disagreeing},
            {"rms_sigmas", number(s.rms_sigmas)},
            {"seconds", s.seconds},
            {"agrees", s.disagreeing == 0}};
}

std::string closed_forms_text(const std::vector<Row>& rows) {
    std::vector<std::vector<std::string>> cells;
    for (const Row& r : rows) {
        const Measured& m = r.measured;
        const bool relative = r.form.expected != 0;
        cells.push_back({r.form.name, fmt::format("{:.8g}", r.form.expected), fmt::format("{:.8g}", m.got), r.form.unit,
                         relative ? fmt::format("{:+.4f}", 100 * r.verdict.relative) : "",
                         relative ? fmt::format("{:.4g}", 100 * r.form.bound) : "",
                         relative && r.form.statistical
                             ? fmt::format("{:.4f}", 100 * m.standard_error / std::fabs(r.form.expected))
                             : "",
                         r.form.statistical ? fmt::format("{:+.2f}", r.verdict.sigmas) : "",
                         fmt::format("{:.2f}", m.seconds), r.verdict.agrees ? "agrees" : "DISAGREES"});
    }
    std::string text = format_table({{"case"},
                                     {"expected", Align::right},
                                     {"got", Align::right},
                                     {"unit"},
                                     {"diff %", Align::right},
                                     {"bound %", Align::right},
                                     {"error %", Align::right},
                                     {"sigmas", Align::right},
                                     {"s", Align::right},
                                     {"verdict"}},
                                    cells);
    const Summary s = summarise(rows);
    text +=
        fmt::format("\n{} of {} agree: within their bounds and, where sampled, within {} standard errors; {:.1f} s\n",
                    s.cases - s.disagreeing, s.cases, max_sigmas, s.seconds);
    if (s.sampled > 0)
        text +=
            fmt::format("root mean square of the sigmas of {} sampled cases: {:.2f}; honest errors give 1 +- {:.2f}\n",
                        s.sampled, s.rms_sigmas, 1 / std::sqrt(2.0 * double(s.sampled)));
    return text;
}

int run_closed_forms(const ClosedFormsOptions& given) {
    const std::vector<Row> rows = measure_all(given);
    const std::string text = given.common.json ? json_text(closed_forms_json(rows)) : closed_forms_text(rows);
    std::fputs(text.c_str(), stdout);
    return summarise(rows).disagreeing == 0 ? success : disagreement;
}

}  // namespace

void add_closed_forms(CLI::App& experiment, Action& action) {
    auto given = std::make_shared<ClosedFormsOptions>();
    CLI::App* forms = experiment.add_subcommand(
        "closed-forms", "hold path tracer, ambient occlusion and rsm.all against light whose amount is known");
    forms->add_option("--error", given->error_percent, "standard error to reach, in percent; 0.06 otherwise")
        ->check(number_within(0.01, 10))
        ->type_name("E");
    forms->add_option("--seed", given->seed, "of all random numbers; 1 otherwise")->type_name("N");
    forms->add_option("--rays", given->rays, "native, or exact: the same bits everywhere")
        ->check(CLI::IsMember({"native", "exact"}).description(""))
        ->type_name("RAYS");
    forms->add_option("--only", given->only, "only the cases with TEXT in their name")->type_name("TEXT");
    add_common(*forms, given->common);
    forms->footer(
        "A case disagrees, exit code 1, where it is off by more than its bound or, if it is sampled, by more than 3\n"
        "standard errors: by chance one of 370 sampled cases does.");
    forms->callback([given, &action] { action = [=] { return run_closed_forms(*given); }; });
}

}  // namespace plumb::cli
