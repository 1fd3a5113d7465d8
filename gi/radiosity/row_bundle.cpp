#include "gi/radiosity/row_bundle.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "core/error.h"
#include "gi/radiosity/gather_kernel.h"

namespace plumb::radiosity {

namespace {

// A list of vectors, or of numbers, as numbers.
template <class Number, class List>
void lend_list(Bundle& b, const char* name, std::int64_t columns, const List& list) {
    lend(b, name, {std::int64_t(list.size()), columns}, static_cast<const Number*>(static_cast<const void*>(list.data())));
}
template <class Number, class List>
void take(const Bundle& b, const char* name, std::int64_t count, std::int64_t columns, List& list) {
    const auto from = elements<Number>(b, name, {count, columns});
    list.resize(from.size() / std::size_t(columns));
    if (!list.empty()) std::memcpy(static_cast<void*>(list.data()), from.data(), from.size_bytes());
}

// Every place that a gather reads.
void check(const RowBlock& b, int elements) {
    const auto wrong = [](const char* what) { throw InputError(fmt::format("rows: {} out of range", what)); };
    std::int64_t runs = 0, weights = 0;
    for (const glm::ivec4& row : b.rows) {
        if (row.x != runs || row.y < 0 || row.z != weights || row.w < 0) wrong("a row");
        runs += row.y;
        if (runs > std::int64_t(b.runs.size())) wrong("a run");
        for (std::int64_t r = row.x; r < runs; ++r) {
            const glm::ivec2 run = b.runs[std::size_t(r)];
            if (run.x < 0 || run.y < 0 || run.x > elements - run.y) wrong("an element");
            weights += run.y;
        }
        if (weights != std::int64_t(row.z) + row.w) wrong("a weight");
    }
    if (runs != std::int64_t(b.runs.size()) || weights + row_lanes != std::int64_t(b.weights.size())) wrong("a weight");
}

}  // namespace

Bundle bundle_of(const RowBlock& b) {
    Bundle bundle;
    lend_list<std::int32_t>(bundle, "rows", 4, b.rows), lend_list<std::int32_t>(bundle, "runs", 2, b.runs);
    lend_list<Half>(bundle, "weights", 1, b.weights), lend_list<float>(bundle, "scale", 1, b.scale);
    lend_list<float>(bundle, "escaped", 1, b.escaped), lend_list<float>(bundle, "back", 1, b.back);
    lend_list<double>(bundle, "sum", 1, b.sum);
    return bundle;
}

RowBlock block_of(const Bundle& bundle, int elements, int index) {
    RowBlock b;
    b.first = index * rows_of_block, b.count = std::min(rows_of_block, elements - b.first);
    take<std::int32_t>(bundle, "rows", b.count, 4, b.rows), take<std::int32_t>(bundle, "runs", any_extent, 2, b.runs);
    take<Half>(bundle, "weights", any_extent, 1, b.weights), take<float>(bundle, "scale", b.count, 1, b.scale);
    take<float>(bundle, "escaped", b.count, 1, b.escaped), take<float>(bundle, "back", b.count, 1, b.back);
    take<double>(bundle, "sum", b.count, 1, b.sum);
    check(b, elements);
    return b;
}

}  // namespace plumb::radiosity
