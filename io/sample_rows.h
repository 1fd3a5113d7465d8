// Sample patterns of a user's own: .npy, [N, 3], a row a sample: dx, dy in texels of the map from the projection of the
// shading point, and the texels that the sample stands for.
#pragma once

#include "core/sample_rows.h"

namespace plumb::io {

// `place` names the parameter that says so. Throws InputError for a file that cannot be read, another shape, and numbers
// that are not finite, or out of range: |dx|, |dy| at most 32767, weights from 0. Null for an empty path.
SampleRowsPtr read_sample_rows(const std::string& name, const std::string& path, const std::string& place);

}  // namespace plumb::io
