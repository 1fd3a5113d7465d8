// The kernels of receiver_rays_kernel.h, one specialisation per instruction set (receiver_rays_isa.cpp).
#pragma once

#include "core/isa.h"
#include "gi/probes/receiver_rays_kernel.h"

namespace plumb::probes {

template <Isa isa>
struct ReceiverRays {
    // Rays [first, last) of all receivers.
    static RayCounts trace(const ReceiverRaysView& in, const RayQuery& query, int first, int last);
    // Receivers [first, last).
    static std::uint64_t test(const TestRaysView& in, const RayQuery& query, int first, int last);
};

}  // namespace plumb::probes
