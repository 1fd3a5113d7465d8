// What Bounded (core/bounded.h) asks of the thread that it runs on: how much an operation may err, and what to do where
// a comparison or a rounding to an index is undecided, that is, may come out in another way on another device.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace plumb {

struct Precision;  // core/device_profile.h

// The discrete choices of one invocation of a kernel. A kernel that runs while a Decisions is installed meets them in
// an order of its own; each takes the option that the path names, and a new one takes the first, which is the float
// kernel's. next_path() moves on to the next combination, depth first. Or they are not told apart: in `widen` mode a
// select() gives the hull of both operands, and an index that is undecided makes the outcome ambiguous.
class Decisions {
  public:
    bool widen = false;
    std::span<const std::int32_t> prescribed;  // what the device chose, in the kernel's order of chosen()

    bool ambiguous = false;  // an index was undecided and its options were not followed
    bool illegal = false;    // a prescribed choice that no device can make

    // Starts a run along the current path.
    void begin() { ambiguous = illegal = false, at_ = next_prescribed_ = 0, slots_.clear(); }
    // To the next combination; false after the last.
    bool next_path();
    // How many options each decision of the last run had.
    std::vector<int> options() const;
    // To the path that takes this option at the decision of that number, and everywhere else the float kernel's own.
    void part_at(std::size_t decision, int option);
    // How many decisions the run has met.
    std::size_t met() const { return at_; }

    // A number for an undecided comparison. It becomes a decision only where its result matters: at flipped().
    std::int32_t slot() { return slots_.push_back(unasked), std::int32_t(slots_.size()); }
    bool flipped(std::int32_t slot);
    // One of so many options.
    int choose(int options);
    // Whether the next choice is prescribed, and which.
    bool take_prescribed(std::int32_t& choice);

  private:
    static constexpr std::int8_t unasked = -1;
    struct Step {
        int taken, options;
    };
    std::vector<Step> path_;
    std::vector<std::int8_t> slots_;  // unasked, or whether it is flipped
    std::size_t at_ = 0, next_prescribed_ = 0;
};

// Roundings are relative to the result: units in the last place times 2^-23, which no unit exceeds, and a little more
// for the second order and for double precision.
inline constexpr double ulp_ratio = 0x1p-23 * (1 + 0x1p-30);

struct BoundedState {
    // The defaults are those of struct Precision.
    double add = 1 * ulp_ratio, multiply = 1 * ulp_ratio;
    double divide = 3.5 * ulp_ratio;  // as a (1/b): the reciprocal's and the product's
    double sqrt = 4.5 * ulp_ratio;
    double exp2 = 3 * ulp_ratio, exp2_slope = 2 * ulp_ratio;
    double log2 = 3 * ulp_ratio, log2_absolute = 0x1p-21;
    double flushed = 0x1p-126;    // operands up to this size may count as 0
    double underflow = 0x1p-126;  // what a denormal result may lose
    Decisions* decisions = nullptr;
};
extern constinit thread_local BoundedState bounded_state;

// Until the end of the scope, operations of this thread may err as much as that.
class PrecisionScope {
  public:
    explicit PrecisionScope(const Precision& precision);
    ~PrecisionScope();
    PrecisionScope(const PrecisionScope&) = delete;
    PrecisionScope& operator=(const PrecisionScope&) = delete;

  private:
    BoundedState saved_;
};

// Until the end of the scope, undecided comparisons of this thread go to `decisions`; without one they mark their
// result as ambiguous.
class DecisionScope {
  public:
    explicit DecisionScope(Decisions& decisions) : saved_(bounded_state.decisions) {
        bounded_state.decisions = &decisions;
    }
    ~DecisionScope() { bounded_state.decisions = saved_; }
    DecisionScope(const DecisionScope&) = delete;
    DecisionScope& operator=(const DecisionScope&) = delete;

  private:
    Decisions* saved_;
};

}  // namespace plumb
