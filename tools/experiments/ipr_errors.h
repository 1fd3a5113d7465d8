// plumb experiment ipr: errors against path tracing, and the truth that they are held against.
#pragma once

#include <vector>

#include "core/signed_error.h"

namespace plumb::cli {

// Of luminance, over receivers or pixels; all but truth relative to the truth's mean. Throws InputError where no light is.
struct IprErrors {
    int count = 0;
    double truth = 0;  // mean, W/m2
    double noise = 0;  // of the truth: root of the mean squared standard error
    double mean = 0;   // of |error|; the truth's noise is in it
    double bias = 0;   // mean error
    double rms = 0;    // the truth's noise taken out
};
IprErrors ipr_errors(const compare::Plane& own, const compare::Plane& truth, const compare::Plane& error,
                     const Image<std::uint8_t>& compared = {});

struct IprTruth {
    std::vector<int> index;         // receivers
    compare::Plane mean, error;     // luminance, W/m2, in their order
    int samples = 0;
};

}  // namespace plumb::cli
