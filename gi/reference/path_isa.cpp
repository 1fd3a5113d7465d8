#include "core/wide.h"
// After core/wide.h, so that the kernel sees its number.
#include "gi/reference/path_rows.h"

namespace plumb::reference {

template <>
std::uint64_t PathRows<Isa::PLUMB_ISA>::trace(const PathArgs& in, const RayQuery& query, int last_row) {
    if (in.faceted) return trace_paths<PLUMB_ISA::Real, true>(in, query, last_row);
    return trace_paths<PLUMB_ISA::Real>(in, query, last_row);
}

}  // namespace plumb::reference
