// One pixel's named values on both sides: our kernel's and those of its twin on a device, and where they part.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/tap.h"

namespace plumb::parity {

struct TwoValues {
    std::string name;
    int sample = -1;
    std::string equation;
    // Empty on the side that has no such value: a loop that ended earlier there, a branch that was not taken.
    std::optional<std::vector<double>> ours, theirs;
    bool compared = true;   // the twin names this value, too
    // The same bits as floats, but that a NaN is the same as any NaN, and 0 as -0: of two zeros max() may return either
    // (Vulkan 1.3, SignedZeroInfNanPreserve). Where a sign matters, what follows from it differs.
    bool same = true;
    std::uint64_t ulp = 0;  // of the component that is farthest off: how many floats apart; a NaN is as far as can be
};

struct SideBySide {
    std::vector<TwoValues> lines;         // in our order; what the device has beyond it stands where it came about
    std::optional<std::size_t> parts_at;  // the first line where they part
    std::size_t compared = 0;             // lines
    std::size_t signs = 0;                // of these, the same but for the sign of a zero
};

// The k-th value of a name and a sample goes with the k-th of the other side. `named`: the names that the twin has.
SideBySide side_by_side(const std::vector<TapValue>& ours, const std::vector<TapValue>& theirs,
                        const std::vector<std::string>& named);

}  // namespace plumb::parity
