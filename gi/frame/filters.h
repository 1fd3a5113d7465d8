// The filters of indirect light in a frame (gi/filter).
//
//     position, normal --filter.reduce--> half_position, half_normal --gathers--> gathered
//     gathered --screen.reuse (with the last frame's)--> reused
//     gathered or reused --filter.upsample--> upsampled --filter.blur (horizontal)--> blurred_across --(vertical)--> indirect
//
// The last filter's result is `indirect`. Without filters gathers add to `indirect` themselves.
#pragma once

#include "gi/frame/frame.h"

namespace plumb::frame {

bool sums_gathers(const Settings& settings);     // indirect light is a sum of gathers, or nothing
bool filters_indirect(const Settings& settings);
bool halves_indirect(const Settings& settings);  // gathers run at half size

// What [indirect] blur means: automatic is separable where a gather samples the map and no frames share light, else none.
filter::Blur blur_of(const Settings& settings);

// Size of the images that gathers write.
glm::ivec2 gather_size(const Settings& settings, glm::ivec2 frame_size);
// The sum of the gathers, filtered or not.
inline const Image4& gather_sum(const Frame& frame) { return frame.gathered.empty() ? frame.indirect : frame.gathered; }

// Squares of an image that see a surface.
raster::Covered covered_by(const Image4& normal);

}  // namespace plumb::frame
