// plumb stability: every stage in the stiff and extreme cases, float against double.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "io/file.h"
#include "tools/plumb/cli.h"
#include "tools/plumb/stability_report.h"
#include "tools/shared/announce.h"
#include "tools/shared/progress.h"
#include "tools/shared/table.h"

namespace plumb::cli {

namespace {

struct Given {
    Common common;
    stability::Filter filter;
    stability::Effort effort;
    std::string html;
    bool list = false;
};

int list_cases(bool json) {
    Json list = Json::array();
    std::vector<std::vector<std::string>> rows;
    for (const stability::CaseInfo& c : stability::case_infos()) {
        list.push_back({{"name", c.name}, {"group", c.group}, {"meaning", c.meaning}});
        rows.push_back({c.group, c.name, c.meaning});
    }
    std::fputs((json ? json_text({{"cases", list}}) : format_table({{"group"}, {"case"}, {"meaning"}}, rows)).c_str(),
               stdout);
    return success;
}

// Of one core, about: a case with all its stages, and with one (mostly its frames).
constexpr double seconds_a_case = 1.3, seconds_a_cell = 0.07;

// All of the cases are what the bar shows of a frame: a stage.
constexpr const char* bar_label = "cases";
frame::Plan as_plan(const stability::Filter& filter) {
    frame::PlannedStage cases;
    cases.label = bar_label, cases.expected_ms = 1;
    cases.samples = filter.case_name.empty() ? int(stability::case_infos().size()) : 1;
    frame::Plan plan;
    plan.stages = {cases};
    return plan;
}

int run_stability(const Given& given) {
    stability::Effort effort = given.effort;
    effort.run = given.common.run_options();
    if (given.list) return list_cases(given.common.json);
    const bool every_stage = given.filter.stage.empty();
    const std::size_t cases = given.filter.case_name.empty() ? stability::case_infos().size() : 1;
    announce(fmt::format("stability: {} case{} of {}", cases, cases == 1 ? "" : "s", every_stage ? "every stage" : given.filter.stage),
             double(cases) * (every_stage ? seconds_a_case : seconds_a_cell), effort.run);
    std::vector<stability::Cell> cells;
    {
        ProgressBar bar(as_plan(given.filter));
        const frame::Progress show = bar.callback();
        cells = stability::run(given.filter, effort, [&](double done) {
            if (show) show(bar_label, done);
        });
    }
    if (!given.html.empty()) io::write_text(given.html, stability_html(cells));
    std::fputs((given.common.json ? json_text(stability_json(cells)) : stability_text(cells)).c_str(), stdout);
    return passed(cells) ? success : disagreement;
}

}  // namespace

void add_stability(CLI::App& program, Action& action) {
    auto given = std::make_shared<Given>();
    CLI::App* command =
        program.add_subcommand("stability", "hold float against double, every stage in stiff and extreme cases");
    command->add_option("--stage", given->filter.stage, "of this stage alone; all otherwise")
        ->check(some_word())
        ->type_name("S");
    command->add_option("--case", given->filter.case_name, "of this case alone; all otherwise")
        ->check(some_word())
        ->type_name("C");
    command->add_option("--pixels", given->effort.pixels, "of a dispatch that are looked at; 64 otherwise")
        ->check(CLI::Range(1, 1 << 20).description(""))
        ->type_name("N");
    command->add_option("--html", given->html, "also write the heat map as a page")
        ->check(some_word())
        ->type_name("FILE");
    command->add_flag("--list", given->list, "list the cases and what they mean; runs nothing");
    add_common(*command, given->common);
    command->footer(
        "A cell is ok where |float - double| <= C eps condition |double| at every pixel that was looked at, or where "
        "the\n"
        "stage says before it computes that it cannot serve the case. Exit code 1 if any is not, or none was looked "
        "at.");
    command->callback([given, &action] { action = [given] { return run_stability(*given); }; });
}

}  // namespace plumb::cli
