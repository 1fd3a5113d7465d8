// Guesses at a formula: the stage's twin with one change each, run on a Vulkan device with what was dumped.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "gi/parity/hypothesis.h"

namespace plumb::cli {

class TwinMutants {
  public:
    // Throws InputError for a device that is not there, and where this program was built without Vulkan.
    explicit TwinMutants(const std::string& device);
    ~TwinMutants();

    // One a place of the twin's SPIR-V (of a raster stage of its fragment stage); none where the device cannot run it.
    // Both arguments, and this object, have to outlive them.
    std::vector<parity::Hypothesis> of(const StageBinding& binding, const StageData& data) const;

  private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

}  // namespace plumb::cli
