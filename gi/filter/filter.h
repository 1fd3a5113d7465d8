// The stages filter.reduce, filter.upsample and filter.blur: irradiance that was gathered at half size, or with noise,
// becomes irradiance of every pixel (VRSM 4.4, 4.5, fig. 4.4). They know nothing of what gathered it. See
// gi/filter/README.md.
#pragma once

#include "gi/filter/blur.h"
#include "gi/filter/reduce.h"
#include "gi/filter/upsample.h"
#include "gi/lend.h"

namespace plumb::filter {

using plumb::explain;
using plumb::run;

}  // namespace plumb::filter
