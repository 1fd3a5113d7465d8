// A sample pattern of one's own in place of the table of offsets that a gather reads.
#pragma once

#include <string>

#include "core/binding.h"
#include "io/manifest.h"

namespace plumb::cli {

// The table of samples that the stage reads, or null: whole texels ("offsets"), or positions.
const Slot* pattern_slot(const StageBinding& binding);

// [N][2] dx, dy or [N][3] dx, dy, weight, from the projection of x, or of a tile one of these for each pixel: sets the table,
// the weights, and the members of the block that follow. The stage's images are there. Throws InputError at `place`.
void set_pattern(const StageBinding& binding, const io::DumpSpec& spec, const std::string& place, StageData& data);

// "; where a shader samples between texels, stage = ...": what to say of an offset that lies between them, where another stage
// takes it.
std::string continuous_stage(const StageBinding& binding);

// Of a row whose dx or dy is d: what was expected.
std::string texels_fault(const std::string& place, std::size_t row, double d, bool whole);

}  // namespace plumb::cli
