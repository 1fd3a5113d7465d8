// Every stage that has a twin, bound by name; and the data of a frame's dispatches.
#pragma once

#include <string>
#include <vector>

#include "core/binding.h"
#include "gi/frame/frame.h"

namespace plumb::parity {

const std::vector<StageBinding>& bindings();
// Throws InputError at `place` that names the nearest known one.
const StageBinding& find_binding(const std::string& stage, const std::string& place);

// One StageData for each dispatch and draw of the frame that has a twin, in order: inputs are the frame's own buffers. A
// point light takes six of every stage that reads its maps. A frame that was planned and not executed gives the same
// with images of zeros: uniforms, patterns and geometry do not depend on them.
std::vector<StageData> frame_data(const Scene& scene, const frame::Settings& settings,
                                  const frame::Plan& plan, const frame::Frame& frame);

}  // namespace plumb::parity
