// Rows between runs and beyond memory: each block of them is kept in a store under a key of what it was made from, and blocks that
// do not fit into memory are read from there whenever they are gathered. Which way they come changes no bit of them.
//
// Only what hemicubes see is in the key: where elements look from, the triangles and their elements, size and weights. Lamps,
// reflectances and the camera are not; neither are instruction sets and threads, on which no bit depends.
#pragma once

#include <cstdint>

#include "gi/graph/store.h"
#include "gi/radiosity/rows.h"

namespace plumb::radiosity {

// What is known before a row is made, bytes.
struct RowPlan {
    std::uint64_t expected = 0;     // of all rows
    std::uint64_t most = 0;         // of all rows, at most
    std::uint64_t block = 0;        // of a block, at most
    bool fits = true;               // all of them in memory
};
// memory: bytes that rows may take there. Throws InputError with the number where not even two blocks fit, and where rows may not
// fit and there is no store.
RowPlan plan_rows(int elements, int size, std::uint64_t memory, bool has_store);

// What making all rows is expected to take on one core, s: an order of magnitude.
double row_seconds(int elements, std::size_t triangles, int size);

struct RowsWith {
    RunOptions options;
    std::uint64_t memory = ~std::uint64_t(0);  // bytes that rows may take there
    graph::Store* store = nullptr;             // must outlive the rows where they do not fit; null: none
};
struct RowsMade {
    FormFactors factors;
    int found = 0;  // blocks that the store had
};

// form_factors(), through a store. `elements` may go afterwards. Throws InputError where rows fit neither into memory nor on disk.
RowsMade rows_within(const Elements& elements, const RowParams& params, const RowsWith& with);

// Of all that rows are made from.
std::uint64_t rows_key(const Elements& elements, const RowParams& params);

}  // namespace plumb::radiosity
