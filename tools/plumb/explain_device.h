// plumb explain --device: a pixel's values of our kernel beside those of its twin, from the same inputs.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "gi/frame/frame.h"
#include "gi/parity/side_by_side.h"
#include "tools/shared/reports.h"

namespace plumb::cli {

// One dispatch or draw.
struct DeviceExplanation {
    std::string stage;  // as people read it: "rsm.disc (bulb) px"
    glm::ivec2 pixel{0};
    std::string device, profile;  // empty device: `reason` says why nothing ran there
    std::string reason;
    parity::SideBySide values;
};

class DeviceExplainer {
  public:
    // Throws InputError for a device that is not there, and where this program was built without Vulkan. `spirv`: a
    // file that runs in place of the stage's tapped twin, of its fragment stage; empty: none.
    DeviceExplainer(const std::string& device, const std::string& spirv);
    ~DeviceExplainer();

    // Every dispatch of the stage that serves the pixel: of a point light's the one whose map does, and all gathers.
    // `required`: throws InputError where the stage has no twin, or the device cannot run it with taps.
    std::vector<DeviceExplanation> explain(const Scene& scene, const frame::Settings& settings,
                                           const frame::Plan& plan, const frame::Frame& frame,
                                           const frame::PlannedStage& stage, glm::ivec2 pixel, bool required) const;

  private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

Json explain_json(const DeviceExplanation& explanation);
std::string explain_text(const DeviceExplanation& explanation);
// The last line of the text alone: whether the values are the same, or where they part.
std::string summary_text(const DeviceExplanation& explanation);

}  // namespace plumb::cli
