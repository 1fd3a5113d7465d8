// The kernel of path_kernel.h over bands of rows, one specialisation per instruction set (path_isa.cpp).
#pragma once

#include "core/isa.h"
#include "gi/reference/path_kernel.h"

namespace plumb::reference {

template <Isa isa>
struct PathRows {
    static std::uint64_t trace(const PathArgs& in, const RayQuery& query, int last_row);
};

}  // namespace plumb::reference
