// The kernels of all_rays_kernel.h over rows of pixels, one specialisation per instruction set (all_rays_isa.cpp).
#pragma once

#include <cstdint>

#include "core/isa.h"
#include "gi/rsm/all_rays_kernel.h"

namespace plumb::rsm {

// Rows are best handed out four at a time: packets are tiles up to that high.
inline constexpr int all_rays_band = 4;

// Returns how many rays were traced.
template <Isa isa>
std::uint64_t all_rays_rows(const AllRaysView& in, const RayQuery& query, RayOffsets offsets, int first, int last);

}  // namespace plumb::rsm
