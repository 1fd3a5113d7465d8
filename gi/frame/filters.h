// The filters of indirect light in a frame (gi/filter): which of them run, what each reads, and where it leaves what it
// makes.
//
//     position, normal --filter.reduce--> half_position, half_normal --gathers--> gathered
//     gathered --filter.upsample--> upsampled --filter.blur (horizontal)--> blurred_across --(vertical)--> indirect
//
// The last filter's result is `indirect`. Without filters gathers add to `indirect` themselves.
#pragma once

#include <string>
#include <vector>

#include "gi/frame/frame.h"

namespace plumb::frame {

// Stages by name and form: {"filter.reduce", "position"}, ..., in the order in which they run; none without filters.
struct FilterStage {
    std::string name, form;
};
std::vector<FilterStage> filters_before_gathers(const Settings& settings);
std::vector<FilterStage> filters_after_gathers(const Settings& settings);

bool is_filter(const std::string& stage);  // "filter.reduce" and its like
bool filters_indirect(const Settings& settings);
bool halves_indirect(const Settings& settings);  // gathers run at half size

// Size of the images that gathers write.
glm::ivec2 gather_size(const Settings& settings, glm::ivec2 frame_size);
// What a stage writes: of the filters, filter.reduce alone is of half size.
glm::ivec2 stage_size(const Settings& settings, const PlannedStage& stage, glm::ivec2 frame_size);

// Where a filter leaves what it makes, and the name of that member of Frame.
Image4& filter_result(Frame& frame, const Settings& settings, const PlannedStage& stage);
std::string filter_place(const Settings& settings, const PlannedStage& stage);

const Image4& filter_result(const Frame& frame, const Settings& settings, const PlannedStage& stage);
// The sum of the gathers, filtered or not.
inline const Image4& gather_sum(const Frame& frame) { return frame.gathered.empty() ? frame.indirect : frame.gathered; }

const Image4& reduce_input(const Frame& frame, const PlannedStage& stage);
filter::UpsampleInputs upsample_inputs(const Frame& frame);
filter::BlurInputs blur_inputs(const Settings& settings, const Frame& frame, const PlannedStage& stage);

// Squares of the half-size image that see a surface.
raster::Covered covered_by(const Image4& normal);

}  // namespace plumb::frame
