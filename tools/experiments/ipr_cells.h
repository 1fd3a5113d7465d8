// plumb experiment ipr: what its text and its page share.
#pragma once

#include "tools/experiments/ipr.h"

namespace plumb::cli {

const std::vector<std::string>& ipr_heads();
std::vector<std::string> ipr_cells(const IprRow& row);
const char* ipr_legend();
std::string goal_text(const IprGoal& goal);
std::string quads_text(const IprQuads& quads);
std::string lightmap_text(const IprLightmap& lightmap);
IprSheet lod_sheet(const IprLodTable& table);
const LodTable* thesis_table(const IprLodTable& table);  // null: none

}  // namespace plumb::cli
