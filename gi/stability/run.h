// The table of stages by cases: every case through a frame, and every stage of that frame looked at.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "gi/stability/stability.h"

namespace plumb::stability {

// Chooses a stage and a case; empty: all.
struct Filter {
    std::string stage, case_name;
};

// The name of a case and its meaning: those of cases.h, then those that have no frame (unbound.h, bake.h).
struct CaseInfo {
    std::string name, group, meaning;
};
const std::vector<CaseInfo>& case_infos();

// The stages that are looked at, in the order of `plumb stages`; then "visibility", which two of them draw with.
const std::vector<std::string>& stage_names();

// Called after each case with the share of the cases that is done, by one thread at a time.
using Progress = std::function<void(double done)>;

// Case by case, stage by stage in their order. A stage that does not run in a case has no cell there. In every case the
// disc gather and that of all texels, hard shadows and their density, and every tone curve are looked at. What a stage
// refuses is a cell that is `refused`; anything else that goes wrong is a cell that is not ok. Threads take whole cases,
// so that no number depends on how many there are. Throws InputError for a stage or case that does not exist, naming the
// nearest.
std::vector<Cell> run(const Filter& filter, const Effort& effort, const Progress& progress = {});

}  // namespace plumb::stability
