// Light whose amount is known: every closed form that the path tracer, the gather over a reflective shadow map and
// ambient occlusion can be held against, as one list. See gi/reference/README.md.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/isa.h"
#include "core/ray_query.h"

namespace plumb::reference {

struct ClosedFormOptions {
    double error = 0.0006;  // relative standard error to reach, as far as a pilot run can tell
    std::uint32_t seed = 1;
    Rays rays = Rays::native;
    RunOptions run;
};

// What our program finds, as the mean over a case's points or pixels.
struct Measured {
    double got = 0;
    double standard_error = 0;  // of `got`
    double seconds = 0;         // with the making of the scene
    std::uint64_t samples = 0;  // paths; of a gather: pairs of point and texel
    std::uint64_t rays = 0;
    std::size_t nonfinite = 0;  // values that are no number
};

struct ClosedForm {
    std::string name;    // "furnace: cube, rho 0.8"
    std::string source;  // the equation, or who published it
    std::string unit;
    double expected = 0;      // from the equation, in double
    double bound = 0;         // of the relative error: 0.002, or what a quadrature errs by itself
    bool statistical = true;  // false: no random number is drawn, and the bound alone decides
    std::function<Measured(const ClosedFormOptions&)> run;
};

// The cases, in the order of verification.md 3.
std::vector<ClosedForm> closed_forms();

// Runs a case with random numbers of its own, given by its name and the seed: no two cases share any.
Measured measure(const ClosedForm& form, const ClosedFormOptions& options);

struct Verdict {
    double relative = 0;  // got / expected - 1; where 0 is expected: got
    double sigmas = 0;    // difference over the standard error, the rounding of floats taken as a part of it
    bool agrees = false;  // within the bound and within max_sigmas; a value that is not finite never agrees
};
Verdict judge(const ClosedForm& form, const Measured& measured, double max_sigmas = 3);

// Whether the standard error is far above rounding, so that `sigmas` of many cases are spread as a normal distribution.
bool is_noisy(const ClosedForm& form, const Measured& measured);

}  // namespace plumb::reference
