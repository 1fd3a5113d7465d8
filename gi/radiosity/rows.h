// Rows of form factors: what each element sees of all others, kept small (house.md: visibility once, reused by every pass and every
// change of light or reflectance).
//
// A row is made of one hemicube: each texel's weight goes to the corners of the triangle that it sees, by barycentrics (vertices),
// or to the triangle; what a back or nothing is seen through is kept as two shares. Weights add up to 1 to rounding.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "core/isa.h"
#include "gi/radiosity/elements.h"
#include "gi/radiosity/items.h"
#include "gi/radiosity/texel_weights.h"

namespace plumb::radiosity {

struct RowParams {
    int size = 64;                      // texels of a hemicube's side
    Weights weights = Weights::exact;
};

// Rows [first, first + count).
struct RowBlock {
    int first = 0, count = 0;
    Buffer<glm::ivec4> rows;            // [count]: first run, runs, first weight, weights; of this block
    Buffer<glm::ivec2> runs;            // first element, elements
    Buffer<Half> weights;               // F_ij / scale; row_lanes zeros behind the last
    Buffer<float> scale;                // [count]
    Buffer<float> escaped, back;        // [count]: shares through which nothing, and a back is seen
    std::size_t bytes() const;
};

struct FormFactors {
    int count = 0;
    std::vector<RowBlock> blocks;
    std::size_t bytes() const;
    // Adds F_i* to a row of `count` numbers.
    void add_row(int i, std::vector<float>& dense) const;
};

inline constexpr int rows_of_block = 256;

// What row i is before it is packed, n numbers; escaped and back beside it.
struct DenseRow {
    std::vector<float> share;
    double escaped = 0, back = 0;
};

// Appends to the block. Halves keep 11 bits; the scale makes their sum that of the floats.
void pack(const DenseRow& row, RowBlock& block);

// All rows. Throws InputError where they need more memory than `limit` bytes (0: no limit).
FormFactors form_factors(const Elements& elements, const RowParams& params, const RunOptions& options, std::uint64_t limit = 0);

// What they are expected to take at most, bytes.
std::uint64_t bytes_expected(int elements, int size);

}  // namespace plumb::radiosity
