// The rules that only a run can ask (rules.h): what the stages before have made tells what the next may leave out.
// Private to gi/frame.
#pragma once

#include "gi/frame/frame.h"

namespace plumb::frame {

// Whether a rule leaves out all of a stage that the plan needs; then `run` says so.
bool left_out_at_run(const Plan& plan, const Frame& frame, const PlannedStage& stage, StageRun& run);

// The tiles that a stage shades, where a rule leaves out others, which `run` tells; empty: all of them. covered: of the
// pixels that it writes; null: the G-buffer's.
raster::Covered tiles_to_shade(const Plan& plan, const Frame& frame, const PlannedStage& stage, StageRun& run,
                               const raster::Covered* covered = nullptr);

// What a stage's run() takes for them.
inline const raster::Covered* or_all(const raster::Covered& tiles) { return tiles.any.empty() ? nullptr : &tiles; }

}  // namespace plumb::frame
