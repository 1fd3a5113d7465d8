// How far float is from double, stage by stage and case by case: `plumb stability`. See gi/stability/README.md.
//
// The kernel runs in float and, along float's decisions, in double, on the same inputs (core/followed.h). How much
// error the inputs themselves explain is measured: each input (a column of an input image or buffer, a number of the
// uniform block) is moved by one ULP, columns by several patterns of signs of which the worst counts, and what the
// double kernel then changes by is added up over the inputs:
//
//     condition = max(1, sum over inputs |f(moved) - f| / (eps |f|)),   eps = 2^-23
//     |float - double| <= C eps condition |f|,                          C = Budget::c of the stage
//
// An error up to 2^-126, the least normal float, is no error of the stage: a device may flush denormals to 0.
#pragma once

#include <string>
#include <vector>

#include "core/binding.h"

namespace plumb::stability {

// One stage in one case, over all its dispatches and all pixels that were looked at.
struct Cell {
    std::string stage, case_name;
    double rel_error = 0;    // worst |float - double| / |double|; of x, y, z relative to the vector's length
    double condition = 1;    // of the component that comes nearest to its bound
    double digits_lost = 0;  // log10(worst |float - double| / (half an ULP of double)), at least 0; relative as above
    double used = 0;         // worst |float - double| / (eps condition |f|): what is used up of C
    std::int64_t nonfinite = 0;  // components that are no finite floats, in float or in double
    std::int64_t flips = 0;      // pixels where double decides otherwise somewhere
    std::int64_t pixels = 0;     // that were looked at
    double budget = 16;          // C
    bool refused = false;        // the stage said in advance that it cannot serve the case
    bool ok = false;             // all finite and used <= C, of at least one pixel, or refused
    std::string reason;          // why refused, or one sentence about the pixel of `used` and `condition`
    std::string most_lost;       // one about the pixel of `digits_lost`, often another; empty where none is lost
};

struct Effort {
    int pixels = 64;   // looked at a dispatch, spread by a hash; all where there are no more
    int patterns = 4;  // of signs, at least 2: away from 0, up, and by a hash
    RunOptions run;
};

// One dispatch. A dispatch whose data cannot be bound is refused, for the reason that binding gives. The same cell for
// any number of threads and any instruction set. Throws std::logic_error where the kernel has other bits than run().
Cell evaluate(const StageBinding& binding, const StageData& data, const Effort& effort);

// Cells of the same stage and case: the worst counts. A default Cell takes over the other.
void merge(Cell& into, const Cell& other);

}  // namespace plumb::stability
