// A selection of receivers, for experiments that check every k-th.
#pragma once

#include <vector>

#include "gi/probes/receivers.h"

namespace plumb::cli {

// Those of these indices, in their order.
probes::Receivers some_of(const probes::Receivers& all, const std::vector<int>& index);

}  // namespace plumb::cli
