// A diagnosis beside the verdict `wrong`: which guesses at what the shader does make its pixels agree, and what its
// wrong pixels have in common. It changes no verdict.
#pragma once

#include <string>
#include <vector>

#include "gi/parity/hypothesis.h"
#include "gi/parity/verdict.h"
#include "gi/parity/wrong_pixels.h"

namespace plumb::parity {

// A guess that explains pixels. Agree: equal or within the bound, as the verdict has it, and a guess that computes
// something may be off by its slack (hypothesis.h) besides; the kernel without it is counted with the same slack.
struct Cause {
    std::string text;
    std::int64_t pixels = 0;              // that were looked at
    std::int64_t agree = 0, without = 0;  // of these: under the guess, and without it
    std::vector<std::string> alike;       // other guesses under which as many agree
    bool aside = false;                   // it leaves something aside: where to look, not what is wrong
    bool fitted = false;                  // a number that was seen or fitted, not a mistake by name
};

// Wrong pixels that lie together, and the guess that explains the most of them.
struct ClusterCause {
    std::int64_t pixels = 0;
    glm::ivec2 low{0}, high{0};
    std::vector<Ratios> ratios;
    std::string text;  // "" where none explains half of them
    std::int64_t looked_at = 0, agree = 0;
};

struct Diagnosis {
    WrongPixels wrong;
    // At most three; each takes away at least half of what is wrong. What explains 99 % of it comes first, and of that
    // mistakes by name.
    std::vector<Cause> causes;
    std::vector<ClusterCause> clusters;  // of the largest, where there are several
    int tried = 0;                       // guesses
    double ms = 0;
};

// Judges nothing, and returns an empty diagnosis, where the verdict is not `wrong`, or nothing was written. `more`:
// guesses of the caller's own.
Diagnosis diagnose(const StageBinding& binding, const StageData& data, const std::vector<Dumped>& dumped,
                   const JudgeOptions& options, const StageVerdict& verdict, const std::vector<Hypothesis>& more = {});

}  // namespace plumb::parity
