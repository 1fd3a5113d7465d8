// Cells of the stages that have no twin and therefore bind no data: rsm.all_rays, reference, hemicube, texture_space,
// and visibility, which the stages gbuffer and rsm draw with. See gi/stability/unbound.md.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/scene.h"
#include "gi/frame/settings.h"
#include "gi/stability/stability.h"

namespace plumb::stability {

// One cell for each of these stages in a scene of stability/cases.h. Throws nothing that a stage throws: what a stage
// refuses is a cell that is `refused`.
std::vector<Cell> unbound_cells(const std::string& case_name, const Scene& scene, const frame::Settings& settings,
                                const Effort& effort);

// Cases that no scene and no frame has: a hemicube of 2 pixels, a chart without area, a closed form at a scale of 1e-4.
struct UnboundCase {
    std::string name, group, meaning;  // as those of Case
    std::function<std::vector<Cell>(const Effort&)> run;
};
const std::vector<UnboundCase>& unbound_cases();

}  // namespace plumb::stability
