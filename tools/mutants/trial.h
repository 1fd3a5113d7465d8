// A mutant on trial: it runs on a device, and the judge says what it thinks of its outputs.
#pragma once

#include <string>
#include <vector>

#include "gi/parity/verdict.h"
#include "tools/mutants/dispatches.h"
#include "tools/mutants/mutant.h"
#include "tools/mutants/on_device.h"

namespace plumb::mutants {

struct Trial {
    parity::Verdict verdict = parity::Verdict::equal;  // the worst of all dispatches
    bool passed = true;                                // every dispatch was
    double ambiguous = 0;                              // largest share of a dispatch
    std::string dispatch;                              // the one that was worst: "cornell: direct"
    parity::WorstPixel worst;
    std::int64_t wrong_pixels = 0, pixels = 0;         // of that one
    int runs = 0;
};

// One thread's: all that it is given must outlive it.
class Judge {
  public:
    Judge(const vulkan::Device& device, const TwinCompiler& compiler, const std::vector<Dispatch>& dispatches,
          const DeviceProfile& profile);

    // The twin as it is.
    Trial unmutated(const std::string& stage);
    // until_wrong: stop at the first dispatch that is wrong.
    Trial operator()(const Mutant& mutant, bool until_wrong, double scale = 1);

  private:
    Trial run(const StageBinding& binding, std::span<const std::uint32_t> spirv, bool until_wrong);

    const TwinCompiler& compiler_;
    OnDevice panels_;
};

// The smallest e for which a factor of 1 + e is found to be wrong, to within a tenth; 0 where not even 0.1 is.
double smallest_error(Judge& judge, const Mutant& mutant);

}  // namespace plumb::mutants
