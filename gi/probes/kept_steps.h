// What each step of a bake makes, as named arrays, and back: how it lies in the store, block by block where it takes long.
//
// lent() copies nothing. take() throws InputError for arrays that are missing, of another type, or do not fit each other; what
// they say is not judged: the store has checksums, and keys that hold the program.
#pragma once

#include "core/bundle.h"
#include "gi/probes/bake.h"

namespace plumb::probes {

Bundle lent(const Atlas& atlas);
void take(const Bundle& kept, Atlas& atlas);

Bundle lent(const Receivers& receivers, const int& moved);
void take(const Bundle& kept, Receivers& receivers, int& moved);

Bundle lent(const Placement& placement, const ProbeRadius& radius);
void take(const Bundle& kept, Placement& placement, ProbeRadius& radius);

Bundle lent(const Supports& supports);
void take(const Bundle& kept, Supports& supports);

// Grid, receivers and supports.
Bundle lent(const Spatial& spatial);
void take(const Bundle& kept, Spatial& spatial);

// Of the relight rays, and of what those of probes [first, first + count) met.
Bundle lent_rays(const Bake& bake);
void take_rays(const Bundle& kept, Bake& bake);
Bundle lent(const RelightHits& hits, int first, int count);
void take(const Bundle& kept, RelightHits& hits, int first, int count);

// alpha: [receivers][row].
Bundle lent(const float* alpha, std::int64_t receivers, std::int64_t row, const RayCounts& counts);
void take(const Bundle& kept, float* alpha, std::int64_t receivers, std::int64_t row, RayCounts& counts);

}  // namespace plumb::probes
