// Where a stage is wrong, and by how much, as pictures.
#pragma once

#include <string>
#include <vector>

#include "gi/parity/diagnosis.h"
#include "gi/parity/verdict.h"
#include "tools/plumb/explain_page.h"

namespace plumb::cli {

// One colour a verdict: grey equal, blue within bound, yellow ambiguous, orange wrong, black not judged; white frames
// around the worst pixels. Of several places that are wrong the largest have a colour each. RGBA8, red in the lowest bits.
Image<std::uint32_t> verdict_picture(const parity::StageVerdict& verdict, const parity::Diagnosis& diagnosis);
// "orange": the colour of the place of that number; of those beyond the last that has one "orange", too.
std::string place_colour(std::size_t place);

// The largest |got - expected| of each pixel's dumped components, as a share of the largest value expected: black where
// the verdict is equal, from 1e-8 dark grey to 1 white by the logarithm, red where either is NaN.
Image<std::uint32_t> error_picture(const parity::StageVerdict& verdict, const std::vector<parity::Dumped>& dumped,
                                   const Bundle& expected);

// Each output that was dumped as it is expected and as it was got, in the same colours.
std::vector<DrawnPicture> output_pictures(const StageBinding& binding, const std::vector<parity::Dumped>& dumped,
                                          const Bundle& expected);

}  // namespace plumb::cli
