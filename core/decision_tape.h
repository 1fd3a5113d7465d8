// The discrete decisions of one invocation of a kernel: what float decided, so that double can take the same way.
//
// float and double part where a comparison or a rounding to an index comes out otherwise; beyond it they compute
// different things, and their difference says nothing about rounding. So float's decisions are recorded and double
// follows them (core/followed.h): what remains is rounding, and where double would have decided otherwise is counted.
#pragma once

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <vector>

namespace plumb {

class DecisionTape {
  public:
    // The next invocation records anew, or follows what was recorded.
    void record() { taken_.clear(), given.clear(), given_index.clear(), start(true); }
    void follow() { start(false); }
    bool recording() const { return recording_; }

    // The next decision: float's own while recording, else the recorded one. An invocation that follows must ask for as
    // many decisions as were recorded.
    std::int32_t decide(std::int32_t of_float, std::int32_t of_double) {
        if (recording_) taken_.push_back(of_float);
        if (at_ == taken_.size()) throw std::logic_error("a kernel asks for decisions that it has not recorded");
        const std::int32_t decision = taken_[at_++];
        flips_ += decision != of_double;
        return decision;
    }

    std::size_t size() const { return taken_.size(); }
    bool at_end() const { return at_ == taken_.size(); }
    std::int64_t flips() const { return flips_; }  // of the last invocation: decisions that double would take otherwise

    // Inputs of this one invocation that no StageData holds, as the triangle and the barycentrics that a
    // rasteriser hands over: recorded, and read again by who follows.
    std::vector<float> given;
    std::vector<std::int32_t> given_index;

  private:
    void start(bool recording) { recording_ = recording, at_ = 0, flips_ = 0; }

    std::vector<std::int32_t> taken_;
    std::size_t at_ = 0;
    std::int64_t flips_ = 0;
    bool recording_ = true;
};

}  // namespace plumb
