// plumb experiment ipr: a table of numbers with pictures and charts, one writer for text, JSON, CSV and page.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/image.h"
#include "tools/experiments/ipr_errors.h"
#include "tools/page/page.h"

namespace plumb::cli {

struct IprPicture {
    std::string caption;
    Image4 picture;  // 0..1, encoded; empty ones are not shown
};
struct IprSheetRow {
    std::string name, settings;
    std::vector<std::optional<double>> values;  // a head each; none: "-"
    std::vector<IprPicture> pictures;
};
struct IprHead {
    std::string name;
    int digits = 0;  // after the point
};
struct IprSheet {
    std::string id, title, notes;  // "table 5.3"
    std::vector<IprHead> heads;
    std::vector<IprSheetRow> rows;
    std::vector<std::string> lines;  // under it
    std::vector<page::Chart> charts;
};

// Four columns, %: mean |error|, bias, rms, the truth's standard error. where: "pixels", ahead of the first.
void add_error_heads(std::vector<IprHead>& heads, const std::string& where);
void add_error_values(std::vector<std::optional<double>>& values, const std::optional<IprErrors>& errors);

std::string sheet_text(const IprSheet& sheet);
page::Json sheet_json(const IprSheet& sheet);
// Lines of scene,table,setting,of,quantity,value; nothing for a value that there is not.
std::string sheet_csv(const std::string& scene, const IprSheet& sheet);
void show_sheet(page::Page& page, const std::string& scene, const IprSheet& sheet);

}  // namespace plumb::cli
