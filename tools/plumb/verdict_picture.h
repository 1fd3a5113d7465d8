// Where a stage is wrong, and by how much, as pictures.
#pragma once

#include "gi/parity/verdict.h"

namespace plumb::cli {

// One colour a verdict: grey equal, blue within bound, yellow ambiguous, red wrong, black not judged; white frames
// around the worst pixels. RGBA8, red in the lowest bits.
Image<std::uint32_t> verdict_picture(const parity::StageVerdict& verdict);

// The largest |got - expected| of each pixel's dumped components, as a share of the largest value expected: black where
// the verdict is equal, from 1e-8 dark grey to 1 white by the logarithm, red where either is NaN.
Image<std::uint32_t> error_picture(const parity::StageVerdict& verdict, const std::vector<parity::Dumped>& dumped,
                                   const Bundle& expected);

}  // namespace plumb::cli
