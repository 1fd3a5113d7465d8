// The table of stages by cases as text, JSON and a page. The JSON's keys are a contract (README.md).
#pragma once

#include <string>
#include <vector>

#include "gi/stability/run.h"
#include "tools/shared/reports.h"

namespace plumb::cli {

// {cells: [{stage, case, rel_error, condition, digits_lost, nonfinite, flips, budget, refused, ok, used, pixels,
// reason}], ok}. null stands for what is no number.
Json stability_json(const std::vector<stability::Cell>& cells);

// Digits lost by case and stage, then every cell that is not ok and every refusal with its reason.
std::string stability_text(const std::vector<stability::Cell>& cells);

// The heat map, and the numbers of each case behind a click. Opens without a network.
std::string stability_html(const std::vector<stability::Cell>& cells);

// True where there is a cell and all are ok.
bool passed(const std::vector<stability::Cell>& cells);

}  // namespace plumb::cli
