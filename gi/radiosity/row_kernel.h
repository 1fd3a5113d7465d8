// A row of form factors from one hemicube: compiled once per instruction set (items_isa.cpp).
#pragma once

#include "core/isa_name.h"
#include "gi/radiosity/items_kernel.h"

namespace plumb::radiosity {

struct RowArgs {
    ItemsView items;             // eyes of all elements; its outputs are not written
    const std::int32_t* of;      // [triangle][4]: element at each corner
    const float* weights;        // [3 size][size]: of texels
};

struct RowShares {
    double escaped, back;        // weights of texels that see nothing, and a back
};

// Adds to share[element] what element i sees of each. `memory`: DrawMemory::floats() floats, aligned to 64 bytes.
template <Isa isa>
struct RowMaker {
    static RowShares run(const RowArgs& in, int i, float* share, float* memory);
};

}  // namespace plumb::radiosity
