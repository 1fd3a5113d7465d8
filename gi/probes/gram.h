// A matrix in pieces that loops over columns take, and its Gram matrix.
#pragma once

#include <cstdint>
#include <vector>

#include "core/image.h"
#include "core/isa.h"
#include "gi/probes/svd.h"
#include "gi/probes/svd_loops.h"

namespace plumb::probes {

// What is summed over, rows or columns, is taken that many at once.
inline constexpr int band = 64;

// The rows with an entry in each block of columns, ascending.
struct Columns {
    struct Entry {
        std::int32_t row;
        const float* values;
    };
    std::vector<std::vector<Entry>> blocks;

    explicit Columns(const BlockMatrix& a);
};

std::vector<std::int32_t> rows_of(const std::vector<Columns::Entry>& entries);
// Columns first .. first + count of one block: [count][padded(entries)].
Buffer<double> transposed(const std::vector<Columns::Entry>& entries, int first, int count);

// A A^T or A^T A, that of the smaller side, as tridiagonalise() takes it.
struct Gram {
    int size, stride;
    bool of_rows;  // A A^T
    Buffer<double> values;

    Gram(const BlockMatrix& a, const Columns& columns, Isa isa);
    Triangle triangle() { return {values.data(), stride}; }
};

}  // namespace plumb::probes
