// The environment in a direction, and directions by its luminance. Tables: environment.h.
#pragma once

#include "core/number.h"

namespace plumb::reference {

struct EnvironmentArgs {
    std::int32_t width, height;  // patches; 0: black
    const float* radiance;
    const float* row_cdf;
    const float* column_cdf;
    const float* pdf;
};

}  // namespace plumb::reference
