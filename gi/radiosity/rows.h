// Rows of form factors: what each element sees of all others, kept small (house.md: visibility once, reused by every pass and every
// change of light or reflectance).
//
// A row is made of one hemicube: each texel's weight goes to the corners of the triangle that it sees, by barycentrics (vertices),
// or to the triangle; what a back or nothing is seen through is kept as two shares. Weights add up to 1 to rounding.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
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
    std::vector<double> sum;            // [count]: of F_i* as they are kept
    std::size_t bytes() const;
};

// Rows that do not lie in memory (kept_rows.h).
class RowSource {
  public:
    virtual ~RowSource() = default;
    // Calls look(block) with all rows from block * rows_of_block on. Several threads may ask; one looks at a time.
    virtual void with_block(int block, const std::function<void(const RowBlock&)>& look) const = 0;
    virtual std::size_t bytes() const = 0;  // of all blocks that it has
};

struct FormFactors {
    int count = 0;
    std::vector<RowBlock> blocks;              // those in memory: the first ones
    std::shared_ptr<const RowSource> further;  // the blocks after them; null: there are none
    Buffer<float> escaped;                     // [count], as RowBlock has it
    std::vector<double> sums;                  // [count], as RowBlock has it
    int longest = 0;                           // numbers that the longest row keeps
    std::size_t bytes() const;                 // in memory
    std::size_t all_bytes() const;
    int block_count() const;
    // Calls look(block) with one after the other.
    void each_block(const std::function<void(const RowBlock&)>& look) const;
    void with_block(int block, const std::function<void(const RowBlock&)>& look) const;
    // Adds F_i* to a row of `count` numbers.
    void add_row(int i, std::vector<float>& dense) const;
    // Takes what all blocks have of a number a row; blocks come in their order.
    void add_facts(const RowBlock& block);
};

inline constexpr int rows_of_block = 256;

// What row i is before it is packed, n numbers; escaped and back beside it.
struct DenseRow {
    std::vector<float> share;
    double escaped = 0, back = 0;
    double sum = -1;  // of F_i*, where more is known of it than floats tell; below 0: that of `share`
};

// Appends to the block. Halves keep 11 bits; the scale makes their sum the row's.
void pack(const DenseRow& row, RowBlock& block);

// All rows. Throws InputError where they need more memory than `limit` bytes (0: no limit).
FormFactors form_factors(const Elements& elements, const RowParams& params, const RunOptions& options, std::uint64_t limit = 0);

// Blocks [first, last) of them; there are blocks_of(elements.count()) in all.
std::vector<RowBlock> row_blocks(const Elements& elements, const RowParams& params, const RunOptions& options, int first, int last);
inline int blocks_of(int elements) { return (elements + rows_of_block - 1) / rows_of_block; }

// What they are expected to take, bytes: each element that is seen once.
std::uint64_t bytes_expected(int elements, int size);
// What they take at most: no two elements that are seen are neighbours.
std::uint64_t bytes_at_most(int elements, int size);

}  // namespace plumb::radiosity
