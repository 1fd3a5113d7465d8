// Whether a lightmap has room for as many receivers as are asked for, before its charts are known.
#pragma once

#include "gi/probes/atlas.h"

namespace plumb::probes {

// Throws InputError where so much surface takes more texels than the largest square has.
void require_room(double area_m2, double receivers_per_m2, int max_size = AtlasParams().max_size);

}  // namespace plumb::probes
