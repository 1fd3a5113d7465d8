#include "tools/experiments/ipr_sheet.h"

#include <fmt/format.h>

#include <algorithm>

#include "tools/shared/table.h"

namespace plumb::cli {

namespace {

std::string cell(const IprHead& head, const std::optional<double>& value) { return value ? fmt::format("{:.{}f}", *value, head.digits) : "-"; }

std::string word(std::string text) {
    std::replace(text.begin(), text.end(), ',', ';');
    return text;
}

}  // namespace

void add_error_heads(std::vector<IprHead>& heads, const std::string& where) {
    heads.insert(heads.end(), {{where + ": mean %", 2}, {where + ": bias %", 2}, {where + ": rms %", 2}, {where + ": truth +- %", 2}});
}

void add_error_values(std::vector<std::optional<double>>& values, const std::optional<IprErrors>& e) {
    if (!e) return values.resize(values.size() + 4);
    values.insert(values.end(), {100 * e->mean, 100 * e->bias, 100 * e->rms, 100 * e->noise});
}

std::string sheet_text(const IprSheet& sheet) {
    std::vector<Column> columns = {{"setting", Align::left}, {"of", Align::left}};
    for (const IprHead& head : sheet.heads) columns.push_back({head.name, Align::right});
    std::vector<std::vector<std::string>> rows;
    for (const IprSheetRow& r : sheet.rows) {
        rows.push_back({r.name, r.settings});
        for (std::size_t i = 0; i < sheet.heads.size(); ++i) rows.back().push_back(cell(sheet.heads[i], r.values[i]));
    }
    std::string text = fmt::format("\n{}: {}{}\n\n", sheet.id, sheet.title, sheet.notes.empty() ? "" : " (" + sheet.notes + ")") + format_table(columns, rows);
    for (const std::string& line : sheet.lines) text += line + "\n";
    return text;
}

page::Json sheet_json(const IprSheet& sheet) {
    page::Json rows = page::Json::array();
    for (const IprSheetRow& r : sheet.rows) {
        page::Json row = {{"name", r.name}, {"settings", r.settings}};
        for (std::size_t i = 0; i < sheet.heads.size(); ++i) row[sheet.heads[i].name] = r.values[i] ? page::Json(*r.values[i]) : page::Json(nullptr);
        rows.push_back(row);
    }
    return {{"id", sheet.id}, {"title", sheet.title}, {"rows", rows}, {"lines", sheet.lines}};
}

std::string sheet_csv(const std::string& scene, const IprSheet& sheet) {
    std::string text;
    for (const IprSheetRow& r : sheet.rows)
        for (std::size_t i = 0; i < sheet.heads.size(); ++i)
            if (r.values[i])
                text += fmt::format("{},{},{},{},{},{:.6g}\n", word(scene), word(sheet.id), word(r.name), word(r.settings), word(sheet.heads[i].name), *r.values[i]);
    return text;
}

void show_sheet(page::Page& page, const std::string& scene, const IprSheet& sheet) {
    page.heading(scene + ", " + sheet.id + ": " + sheet.title);
    std::vector<std::vector<page::Cell>> rows = {{{"setting"}, {"of"}}};
    for (const IprHead& head : sheet.heads) rows[0].push_back({head.name, true});
    for (const IprSheetRow& r : sheet.rows) {
        rows.push_back({{r.name}, {r.settings}});
        for (std::size_t i = 0; i < sheet.heads.size(); ++i) rows.back().push_back({cell(sheet.heads[i], r.values[i]), true});
    }
    page.table(rows, sheet.notes);
    for (const std::string& line : sheet.lines) page.paragraph(line);
    for (const page::Chart& chart : sheet.charts) page.chart(chart);
    for (const IprSheetRow& r : sheet.rows)
        for (const IprPicture& p : r.pictures)
            if (!p.picture.empty()) page.figure(page.picture(p.picture, sheet.id + ", " + r.name + (p.caption.empty() ? "" : ": " + p.caption)));
}

}  // namespace plumb::cli
