#include "tools/plumb/stability_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tools/page/page.h"
#include "tools/shared/table.h"

namespace plumb::cli {

namespace {

using stability::CaseInfo;
using stability::Cell;

const Cell* cell_of(const std::vector<Cell>& cells, const std::string& stage, const std::string& case_name) {
    for (const Cell& c : cells)
        if (c.stage == stage && c.case_name == case_name) return &c;
    return nullptr;
}

// Of the stages and cases that have cells, in the order of the lists.
std::vector<std::string> stages_of(const std::vector<Cell>& cells) {
    std::vector<std::string> names;
    for (const std::string& name : stability::stage_names())
        if (std::any_of(cells.begin(), cells.end(), [&](const Cell& c) { return c.stage == name; }))
            names.push_back(name);
    return names;
}
std::vector<CaseInfo> cases_of(const std::vector<Cell>& cells) {
    std::vector<CaseInfo> infos;
    for (const CaseInfo& info : stability::case_infos())
        if (std::any_of(cells.begin(), cells.end(), [&](const Cell& c) { return c.case_name == info.name; }))
            infos.push_back(info);
    return infos;
}

std::string number_text(double v) { return std::isfinite(v) ? fmt::format("{:.3g}", v) : "none"; }

std::string short_text(const Cell& c) {
    if (c.refused && c.ok) return "refused";
    if (c.nonfinite > 0) return fmt::format("{} no number", c.nonfinite);
    if (!std::isfinite(c.used)) return "failed";
    return fmt::format("{:.1f}{}", c.digits_lost, c.ok ? "" : " !");
}

std::string summary_text(const std::vector<Cell>& cells) {
    const auto count = [&](auto one) { return std::count_if(cells.begin(), cells.end(), one); };
    return fmt::format("{} cells: {} within the budget, {} refused in advance, {} not ok", cells.size(),
                       count([](const Cell& c) { return c.ok && !c.refused; }),
                       count([](const Cell& c) { return c.ok && c.refused; }),
                       count([](const Cell& c) { return !c.ok; }));
}

// Of one stage over all cases.
struct StageSummary {
    std::string stage;
    std::int64_t cells = 0, refused = 0, not_ok = 0, flips = 0;
    const Cell* most_used = nullptr;  // of the cells that computed something
    const Cell* most_lost = nullptr;
};
std::vector<StageSummary> summaries(const std::vector<Cell>& cells) {
    std::vector<StageSummary> all;
    for (const std::string& stage : stages_of(cells)) {
        StageSummary s{stage};
        for (const Cell& c : cells) {
            if (c.stage != stage) continue;
            ++s.cells, s.refused += c.refused && c.ok, s.not_ok += !c.ok, s.flips += c.flips;
            if (c.pixels == 0) continue;
            if (!s.most_used || !(c.used <= s.most_used->used)) s.most_used = &c;
            if (!s.most_lost || !(c.digits_lost <= s.most_lost->digits_lost)) s.most_lost = &c;
        }
        all.push_back(s);
    }
    return all;
}

// The head, then a row a stage.
std::vector<std::vector<std::string>> summary_rows(const std::vector<Cell>& cells) {
    std::vector<std::vector<std::string>> rows = {{"stage", "cells", "refused", "not ok", "most used of C", "in case",
                                                   "most digits lost", "in case", "pixels that flip"}};
    for (const StageSummary& s : summaries(cells)) {
        std::vector<std::string> worst(4, "-");
        if (s.most_used)
            worst = {fmt::format("{:.2f} of {:g}", s.most_used->used, s.most_used->budget), s.most_used->case_name,
                     fmt::format("{:.1f}", s.most_lost->digits_lost), s.most_lost->case_name};
        rows.push_back({s.stage, std::to_string(s.cells), std::to_string(s.refused), std::to_string(s.not_ok), worst[0],
                        worst[1], worst[2], worst[3], std::to_string(s.flips)});
    }
    return rows;
}
bool is_number_column(std::size_t column) { return column != 0 && column != 5 && column != 7; }

// Green to yellow within the budget, red beyond; black what is no number.
double heat_of(const Cell& c) {
    if (c.refused && c.ok) return -1;
    if (c.nonfinite > 0 || !std::isfinite(c.used)) return std::numeric_limits<double>::quiet_NaN();
    if (!c.ok) return 1;
    return 0.5 * c.used / c.budget;
}

// The pixel that uses up most of the budget, and that which loses most digits.
std::string reason_of(const Cell& c) {
    return c.most_lost.empty() ? c.reason : c.reason + "; most digits are lost at " + c.most_lost;
}

std::string hint_of(const Cell& c) {
    return fmt::format("{} in \"{}\"{}\n{:.1f} digits lost, relative error {}\n{} of {:g} used, at condition {}\n{} of {} "
                       "pixels flip, {} values not finite\n{}",
                       c.stage, c.case_name, c.ok ? "" : ": NOT OK", c.digits_lost, number_text(c.rel_error),
                       number_text(c.used), c.budget, number_text(c.condition), c.flips, c.pixels, c.nonfinite,
                       reason_of(c));
}

std::string id_of(std::size_t index) { return fmt::format("case-{}", index); }

page::Cell plain(const std::string& text) { return {.text = text}; }
page::Cell number(double v, const std::string& text) { return {.text = text, .number = true, .order = v}; }
page::Cell number(double v) { return number(v, number_text(v)); }
page::Cell count(std::int64_t n) { return number(double(n), std::to_string(n)); }

// The name may be broken after a dot or an underscore: columns are as narrow as their numbers.
std::string breakable(const std::string& name) {
    constexpr const char* break_here = "\u200b";
    std::string text;
    for (const char c : name) {
        text += c;
        if (c == '.' || c == '_') text += break_here;
    }
    return text;
}

void add_heat_map(page::Page& page, const std::vector<Cell>& cells, const std::vector<CaseInfo>& infos) {
    const std::vector<std::string> stages = stages_of(cells);
    std::vector<std::vector<page::Cell>> rows = {{plain("case")}};
    for (const std::string& stage : stages) rows[0].push_back({.text = breakable(stage), .number = true});
    for (std::size_t i = 0; i < infos.size(); ++i) {
        const std::string link = "#" + id_of(i);
        // A group's name stands above its cases.
        if (i == 0 || infos[i].group != infos[i - 1].group) {
            rows.push_back({{.text = infos[i].group, .badge = "plain"}});
            rows.back().resize(1 + stages.size());
        }
        rows.push_back({{.text = infos[i].name, .hint = infos[i].meaning, .link = link}});
        for (const std::string& stage : stages) {
            const Cell* c = cell_of(cells, stage, infos[i].name);
            if (!c) {
                rows.back().push_back({.text = "", .number = true, .hint = "does not run in this case"});
                continue;
            }
            page::Cell cell{
                .text = short_text(*c), .number = true, .heat = heat_of(*c), .hint = hint_of(*c), .link = link};
            // Beyond every number: what is not ok.
            cell.order = c->ok ? (c->refused ? -1 : c->digits_lost) : 1000 + c->used;
            rows.back().push_back(cell);
        }
    }
    page.table(rows, "Digits lost of float's seven, at the worst pixel. Colour: the share of the budget that is used; "
                     "black: values that are no finite numbers");
}

void add_summary(page::Page& page, const std::vector<Cell>& cells) {
    std::vector<std::vector<page::Cell>> rows;
    for (const std::vector<std::string>& row : summary_rows(cells)) {
        rows.emplace_back();
        for (std::size_t c = 0; c < row.size(); ++c)
            rows.back().push_back({.text = row[c], .number = is_number_column(c)});
    }
    page.table(rows, "The worst of each stage over all cases");
}

void add_details(page::Page& page, const std::vector<Cell>& cells, const std::vector<CaseInfo>& infos) {
    for (std::size_t i = 0; i < infos.size(); ++i) {
        page.heading(infos[i].name, id_of(i));
        page.paragraph(infos[i].meaning + ".");
        std::vector<std::vector<page::Cell>> rows = {
            {plain("stage"), plain("verdict"), {.text = "relative error", .number = true},
             {.text = "condition", .number = true}, {.text = "digits lost", .number = true},
             {.text = "used", .number = true}, {.text = "budget C", .number = true}, {.text = "flips", .number = true},
             {.text = "not finite", .number = true}, {.text = "pixels", .number = true}, plain("reason")}};
        for (const Cell& c : cells) {
            if (c.case_name != infos[i].name) continue;
            rows.push_back({plain(c.stage),
                            {.text = !c.ok ? "not ok" : c.refused ? "refused" : "ok", .heat = heat_of(c)},
                            number(c.rel_error), number(c.condition), number(c.digits_lost), number(c.used),
                            number(c.budget), count(c.flips), count(c.nonfinite), count(c.pixels), plain(reason_of(c))});
        }
        page.table(rows);
    }
}

}  // namespace

bool passed(const std::vector<Cell>& cells) {
    return !cells.empty() && std::all_of(cells.begin(), cells.end(), [](const Cell& c) { return c.ok; });
}

Json stability_json(const std::vector<Cell>& cells) {
    Json list = Json::array();
    for (const Cell& c : cells)
        list.push_back({{"stage", c.stage},
                        {"case", c.case_name},
                        {"rel_error", c.rel_error},
                        {"condition", c.condition},
                        {"digits_lost", c.digits_lost},
                        {"nonfinite", c.nonfinite},
                        {"flips", c.flips},
                        {"budget", c.budget},
                        {"refused", c.refused},
                        {"ok", c.ok},
                        {"used", c.used},
                        {"pixels", c.pixels},
                        {"reason", reason_of(c)}});
    return {{"cells", list}, {"ok", passed(cells)}};
}

std::string stability_text(const std::vector<Cell>& cells) {
    const std::vector<std::string> stages = stages_of(cells);
    std::vector<Column> columns = {{"case"}};
    for (const std::string& stage : stages) columns.push_back({stage, Align::right});
    std::vector<std::vector<std::string>> rows;
    for (const CaseInfo& info : cases_of(cells)) {
        rows.push_back({info.name});
        for (const std::string& stage : stages) {
            const Cell* c = cell_of(cells, stage, info.name);
            rows.back().push_back(c ? short_text(*c) : "-");
        }
    }
    std::string text = format_table(columns, rows);
    for (const bool ok : {true, false}) {
        std::vector<std::vector<std::string>> reasons;
        for (const Cell& c : cells)
            if (c.ok == ok && (c.refused || !ok)) reasons.push_back({c.case_name, c.stage, c.reason});
        if (reasons.empty()) continue;
        text += ok ? "\nrefused in advance\n" : "\nnot ok\n";
        text += format_table({{""}, {""}, {""}}, reasons, 2);
    }
    std::vector<std::vector<std::string>> by_stage = summary_rows(cells);
    std::vector<Column> heads;
    for (std::size_t c = 0; c < by_stage[0].size(); ++c)
        heads.push_back({by_stage[0][c], is_number_column(c) ? Align::right : Align::left});
    by_stage.erase(by_stage.begin());
    text += "\n" + format_table(heads, by_stage);
    return text + "\ndigits lost by float; " + summary_text(cells) + "\n";
}

std::string stability_html(const std::vector<Cell>& cells) {
    page::Page page("Stiff and extreme cases: float against double");
    page.paragraph(summary_text(cells) + ".");
    page.paragraph(
        "Every stage's kernel ran in float and, along float's decisions, in double, on the same inputs. A cell is "
        "within the budget where |float - double| is at most C eps condition |double| at every pixel that was looked "
        "at, or at most 2^-126, with eps = 2^-23 and the condition measured by moving each input by one ULP. A stage "
        "that cannot serve a case says so before it computes: refused. A click on a cell leads to its numbers.");
    const std::vector<CaseInfo> infos = cases_of(cells);
    add_summary(page, cells);
    add_heat_map(page, cells, infos);
    add_details(page, cells, infos);
    return page.html();
}

}  // namespace plumb::cli
