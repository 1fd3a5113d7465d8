// The steps of a bake that no device could run, as `plumb stages` lists them; the others are in stages.cpp.
#pragma once

#include "core/stage.h"

namespace plumb::probes {

StageInfo info_atlas();
StageInfo info_receivers();
StageInfo info_placement();
StageInfo info_spatial();
StageInfo info_directions();
StageInfo info_relight();
StageInfo info_rays();
StageInfo info_clusters();

}  // namespace plumb::probes
