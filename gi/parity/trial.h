// Tries guesses: the kernel under one of them, on some pixels, beside what was dumped there. Private to gi/parity/.
#pragma once

#include <memory>
#include <set>
#include <string>
#include <vector>

#include "core/binding.h"
#include "gi/parity/hypothesis.h"
#include "gi/parity/pair.h"

namespace plumb::parity {

// Pixels that guesses are tried on, with what the kernel as it is may make of them, which all guesses about results
// share.
struct Look {
    std::vector<glm::ivec2> pixels;
    std::vector<std::vector<Outcome>> outcomes = {};
};

// All that it is given must outlive it.
class Trial {
  public:
    Trial(const StageBinding& binding, const StageData& data, const JudgeOptions& options, const StageVerdict& verdict,
          const std::vector<Pair>& pairs);

    Look look(std::vector<glm::ivec2> pixels) const;
    // Finds the images of the frame that the kernel reads at its own pixel alone: of these a look changes its pixels.
    void find_local(const Look& look);

    // A byte a pixel: whether the dump may hold what the guess makes. Empty where the kernel cannot serve such data.
    std::vector<std::uint8_t> agreement(const Hypothesis& h, const Look& look);
    // The same of so many pixels that the float kernel runs over the whole frame first, which spares most bounds.
    std::vector<std::uint8_t> agreement_of_many(const Hypothesis& h, const std::vector<glm::ivec2>& pixels);
    // How far off it is, of each pixel 0 to 1 at most; infinite where the kernel cannot serve such data.
    double distance(const Hypothesis& h, const Look& look);

  private:
    struct Changed;
    std::size_t index(glm::ivec2 p) const;
    bool inside(glm::ivec2 p) const;
    template <class Each>
    void each_of(std::size_t count, const Each& each) const;
    template <class Each>
    bool each_outcomes(const Hypothesis& h, const Look& look, const Each& each);

    bool change(const Hypothesis& h, const std::vector<glm::ivec2>* pixels, Changed& to);
    bool change_texels(const TexelChange& texels, const std::vector<glm::ivec2>& pixels, StageData& data);
    void restore_texels(const TexelChange& texels, const std::vector<glm::ivec2>& pixels);

    std::vector<Outcome> outcomes(const BoundStage& stage, glm::ivec2 ours, std::size_t at) const;
    std::vector<Outcome> own_outcome(const Bundle& outputs, std::size_t at) const;
    std::vector<Outcome> added(const std::vector<Outcome>& to, const std::vector<Outcome>& more, int sign) const;
    bool says_something(const std::vector<BoundedValue>& values) const;
    bool holds(std::size_t at, const std::vector<BoundedValue>& values, double slack) const;
    bool agrees(const Hypothesis& h, const std::vector<Outcome>& outcomes, glm::ivec2 pixel) const;
    double off(std::size_t at, const std::vector<BoundedValue>& values) const;

    const StageBinding& binding_;
    const StageData& data_;
    const JudgeOptions& options_;
    const StageVerdict& verdict_;
    const std::vector<Pair>& pairs_;
    std::unique_ptr<BoundStage> stage_;
    int components_ = 0;
    std::vector<double> largest_;  // of what was dumped of each pair
    std::set<std::string> local_;  // inputs
    // One of them, whose pixels a guess changes and gives back.
    std::string scratch_of_;
    std::vector<float> scratch_;
};

}  // namespace plumb::parity
