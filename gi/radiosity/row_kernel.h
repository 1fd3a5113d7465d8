// A row of form factors from one hemicube: compiled once per instruction set (items_isa.cpp).
#pragma once

#include "core/isa_name.h"
#include "gi/radiosity/items_kernel.h"

namespace plumb::radiosity {

struct RowArgs {
    ItemsUniforms u;
    const float* eyes;           // [element][4][4]: as of ItemsView
    const float* vertices;       // [vertex][4]: xyz m
    DrawList list;
    const std::int32_t* of;      // [triangle][4]: element at each corner
    const float* weights;        // [3 size][size]: of texels
};

struct RowShares {
    double escaped, back;        // weights of texels that see nothing, and a back
};

// A row as halves: the shares times a factor that makes the largest one 2^15, those of at least 2^-14. Below it halves lose bits, and
// some devices all of them.
struct RowHalves {
    std::uint16_t* half;         // [n padded to row_packet]: 0 where it is below
    std::uint16_t* kept;         // [the same / row_packet]: bit k: number row_packet i + k is not
};
inline constexpr int row_packet = 16;

struct RowSums {
    double shares, halves;
};

template <Isa isa>
struct RowMaker {
    // Adds to share[element] what element i sees of each. `memory`: DrawMemory::floats() floats, aligned to 64 bytes.
    static RowShares run(const RowArgs& in, int i, float* share, float* memory);
    // `share`: n numbers, not negative, padded with zeros to row_packet. Sums are those of sixteen lanes, of numbers k, k + 16, ..., added
    // in halves: the same for every instruction set.
    static RowSums halve(const float* share, int n, const RowHalves& out);
};

}  // namespace plumb::radiosity
