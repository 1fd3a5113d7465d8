// How float is held against double where no data is bound: the formulas of evaluate.cpp, over invocations that are
// given as functions. Parts of unbound.cpp.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/followed.h"
#include "gi/stability/moved_inputs.h"
#include "gi/stability/stability.h"

namespace plumb::stability {

// One pixel of a kernel that runs with Followed, on the tape of the thread.
struct Invocation {
    std::string place;  // "pixel (3, 4)"
    std::function<void(std::vector<Followed>& out)> run;
};

struct Subject {
    std::string stage;
    std::vector<std::string> components;  // names of what an invocation hands over
    std::vector<Invocation> invocations;
    std::vector<Input> inputs;  // that they read, each to be moved
};

// All components of all invocations. What an invocation puts on the tape as given (hits of rays) is moved, too.
Cell look(const Subject& subject, const Effort& effort);

// The columns of rows of `stride` floats as inputs.
void add_columns(const std::string& name, float* rows, std::size_t count, std::size_t stride,
                 const std::vector<std::size_t>& columns, std::vector<Input>& out);

// A number beside its truth. `condition` is 1 where no cancellation explains any of the error.
struct Checked {
    double got = 0, truth = 0;
    double condition = 1;
};
// The worst of `numbers` into the cell. `place` names what number i is.
void judge(const std::vector<Checked>& numbers, const std::function<std::string(std::size_t)>& place, Cell& cell);

// A cell of that stage whose verdict stands: something was looked at, all of it finite and within the budget.
void conclude(Cell& cell);

// Runs `body`; what it refuses by an InputError becomes a cell that is refused.
Cell or_refused(const std::string& stage, const std::function<Cell()>& body);

}  // namespace plumb::stability
