// What each light of a frame took: the key "lights" of run.json.
#pragma once

#include "tools/shared/reports.h"

namespace plumb::cli {

// A light each, in the scene's order: ms of the stages that are its own, of those that were kept what they saved, bytes of what they made.
// Stages over all lights at once, as direct light, are nobody's.
Json light_costs_json(const Scene& scene, const frame::Plan& plan, const std::vector<frame::StageRun>& stages);

}  // namespace plumb::cli
