#include "gi/frame/at_run.h"

#include <fmt/format.h>

#include "gi/frame/filters.h"
#include "gi/frame/isr.h"

namespace plumb::frame {

namespace {

Work work_of(const PlannedStage& stage, const char* part = "") {
    if (is_gather(stage.name)) return {"gather", part, stage.light};
    if (is_filter(stage.name)) return {"filter", part, stage.light};
    if (stage.name == "shadow.blur") return {"shadow", part, stage.light};
    if (is_isr(stage.name)) return {isr_work(stage), part, stage.light};
    if (stage.view > 0 && draws_view(stage.name)) return {"isr.view", part, stage.light};
    return {stage.layer.empty() ? stage.name : stage.layer, part, stage.light};
}

Seen seen_by(const Frame& frame, const PlannedStage& stage, const raster::Covered* covered = nullptr) {
    Seen seen{frame.gbuffer, {}, covered ? *covered : frame.gbuffer.covered};
    if (stage.light >= 0) seen.maps = frame.rsms[std::size_t(stage.light)];
    return seen;
}

}  // namespace

bool left_out_at_run(const Plan& plan, const Frame& frame, const PlannedStage& stage, StageRun& run) {
    const Rule* rule = left_out_by(plan.at_run, seen_by(frame, stage), work_of(stage));
    if (!rule) return false;
    run.needed = false;
    run.rule = rule->name, run.reason = rule->reason;
    run.saved_ms += stage.expected_ms;
    return true;
}

raster::Covered tiles_to_shade(const Plan& plan, const Frame& frame, const PlannedStage& stage, StageRun& run,
                               const raster::Covered* covered) {
    const Seen seen = seen_by(frame, stage, covered);
    raster::Covered tiles = seen.covered;
    Work work = work_of(stage, "tile");
    const Rule* by = nullptr;
    std::size_t left_out = 0;
    for (std::size_t i = 0; i < tiles.any.size(); ++i) {
        work.index = int(i);
        const Rule* rule = left_out_by(plan.at_run, seen, work);
        tiles.any[i] = !rule;
        if (rule) by = rule, ++left_out;
    }
    if (!by) return {};
    const std::string reason = fmt::format("{} of {} tiles left out: each {}", left_out, tiles.any.size(), by->reason);
    const double saved_ms = stage.expected_ms * double(left_out) / double(tiles.any.size());
    run.parts.push_back({by->name, reason, saved_ms});
    run.saved_ms += saved_ms;
    return tiles;
}

}  // namespace plumb::frame
