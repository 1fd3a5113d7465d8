// Thinning candidates to a wanted number of equal density (IPR 3.2.2.1, figure 3.14).
//
// Host code: each removal depends on all before it, and costs a look at the neighbours of one candidate.
#pragma once

#include <cstdint>
#include <vector>

#include "core/image.h"
#include "core/isa.h"

namespace plumb::probes {

struct Thinned {
    std::vector<std::int32_t> kept;  // indices of candidates, ascending
    Buffer<float> density;           // K_i of every candidate before any was removed, probes.density
    double radius = 0;               // of the kernel at the end, in the positions' unit
    int doublings = 0;               // of the radius
};

// Removes the candidate with the largest K_i, of equals the one with the lowest index, subtracts its weight from its
// neighbours, and goes on until `wanted` are left. positions: xyz in any unit, radius in the same.
//
// differs: densities are compared in steps of 2^-12, so that the roundings of their sums decide nothing; where no two
// candidates are left within the radius and there are still too many, the radius doubles, as K_i is 0 for all.
// Throws InputError for an empty list, positions that are not finite, a radius that is not a positive number, or
// `wanted` beyond 1 to the number of candidates.
Thinned thin(const Buffer<glm::vec4>& positions, float radius, int wanted, const RunOptions& options);

}  // namespace plumb::probes
