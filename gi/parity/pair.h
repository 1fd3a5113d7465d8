// One dumped output beside ours. Private to gi/parity/.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "core/binding.h"
#include "gi/parity/stored.h"
#include "gi/parity/verdict.h"

namespace plumb::parity {

// One dumped output beside ours.
struct Pair {
    const Slot* slot;
    const Dumped* dumped;
    const unsigned char* expected;  // [height][width][channels]
    int channels = 0;               // of ours
    int dumped_channels = 0;        // of each texel of the dump
    int first = 0;                  // of our channels among all components of all outputs
    double nothing = 0;             // what the output holds before anything is drawn
    bool w_is_flag = false;         // a fourth component that says no more than that there is something

    bool compared(int c) const { return (dumped->channels >> c & 1) && c < dumped_channels; }
    double got(std::size_t pixel, int c) const {
        return value(dumped->array.dtype, dumped->array.bytes.data(), pixel * std::size_t(dumped_channels) + c);
    }
    double ours(std::size_t pixel, int c) const {
        return value(slot->dtype, expected, pixel * std::size_t(channels) + c);
    }
    // Everything that the dump may hold where the shader wrote one of [low, high].
    StoredRange stored(std::size_t pixel, int c, double low, double high, double largest,
                       const DeviceProfile& profile) const {
        if (dumped->rounding.bytes.empty()) return stored_range(dumped->stored, c, low, high, largest, profile);
        const double moved = value(DType::f32, dumped->rounding.bytes.data(), pixel * std::size_t(dumped_channels) + c);
        return {std::clamp(low, dumped->lowest, dumped->highest) - moved,
                std::clamp(high, dumped->lowest, dumped->highest) + moved};
    }

    // Whether no more is expected at the pixel than what stands there before anything is drawn.
    bool expects_nothing(std::size_t pixel) const {
        for (int c = 0; c < channels; ++c)
            if (compared(c) && !(c == 3 && w_is_flag) && ours(pixel, c) != nothing) return false;
        return true;
    }
    // 0 where the dump has the pixel; 1 where it still holds its filling, 2 where its file has ended.
    int unwritten(std::size_t pixel) const { return dumped->unwritten.empty() ? 0 : dumped->unwritten[pixel]; }

  private:
    static double value(DType dtype, const unsigned char* p, std::size_t i) {
        if (dtype == DType::f32) {
            float f;
            std::memcpy(&f, p + 4 * i, 4);
            return f;
        }
        std::int32_t n;
        std::memcpy(&n, p + 4 * i, 4);
        return n;
    }
};

// The first output of which a dump says why nothing was written, and how many there are: ": out/a.bin is missing".
inline std::string absent_outputs(const std::vector<Pair>& pairs) {
    const auto is_absent = [](const Pair& p) { return !p.dumped->absent.empty(); };
    const auto first = std::find_if(pairs.begin(), pairs.end(), is_absent);
    if (first == pairs.end()) return "";
    const auto all = std::count_if(pairs.begin(), pairs.end(), is_absent);
    return ": " + first->dumped->absent + (pairs.size() > 1 ? fmt::format(" ({} of {} outputs)", all, pairs.size()) : "");
}

// All outputs that were dumped, each beside what our kernel makes of it, rounded as the target rounds. `binding`, `data`,
// `dumped` and `options` have to outlive it.
class ComparedPairs {
  public:
    ComparedPairs(const StageBinding& binding, const StageData& data, const std::vector<Dumped>& dumped,
                  const JudgeOptions& options);
    ~ComparedPairs();
    const std::vector<Pair>& all() const;

  private:
    struct Owner;
    std::unique_ptr<Owner> owner_;
};

}  // namespace plumb::parity
