#include "core/wide.h"
// After core/wide.h, so that the kernels see their number.
#include "gi/probes/receiver_rays.h"

namespace plumb::probes {

using F = PLUMB_ISA::Real;

template <>
RayCounts ReceiverRays<Isa::PLUMB_ISA>::trace(const ReceiverRaysView& in, const RayQuery& query, int first, int last) {
    return receiver_rays<F>(in, query, first, last);
}

template <>
std::uint64_t ReceiverRays<Isa::PLUMB_ISA>::test(const TestRaysView& in, const RayQuery& query, int first, int last) {
    return test_rays<F>(in, query, first, last);
}

}  // namespace plumb::probes
