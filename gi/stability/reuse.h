// Cells of screen.reuse: a last frame of which points are seen as they were, from aside, from far away, and not at all.
#pragma once

#include "gi/stability/bake.h"

namespace plumb::stability {

void add_reuse_cases(std::vector<BakeCase>& cases);

}  // namespace plumb::stability
