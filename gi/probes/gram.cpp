#include "gi/probes/gram.h"

#include <algorithm>

namespace plumb::probes {

namespace {

template <Isa isa>
void add_rows_gram(const BlockMatrix& a, const Columns& columns, Gram& g) {
    for (const auto& entries : columns.blocks) {
        const std::vector<std::int32_t> place = rows_of(entries);
        for (int c = 0; c < a.width; c += band) {
            const int count = std::min(band, a.width - c);
            const Buffer<double> b = transposed(entries, c, count);
            MatrixLoops<isa>::add_gram(b.data(), count, int(place.size()), place.data(), g.triangle());
        }
    }
}

template <Isa isa>
void add_columns_gram(const BlockMatrix& a, Gram& g) {
    for (int first = 0; first < a.rows; first += band) {
        // Only the blocks that these rows have.
        const int last = std::min(a.rows, first + band);
        std::vector<std::int32_t> blocks(a.block.begin() + a.first[first], a.block.begin() + a.first[last]);
        std::sort(blocks.begin(), blocks.end());
        blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
        std::vector<std::int32_t> place, start(std::size_t(a.blocks));
        for (std::int32_t b : blocks) {
            start[b] = std::int32_t(place.size());
            for (int c = 0; c < a.width; ++c) place.push_back(b * a.width + c);
        }
        const int stride = padded(int(place.size()));
        Buffer<double> piece(std::size_t(last - first) * stride);
        for (int i = first; i < last; ++i)
            for (int e = a.first[i]; e < a.first[i + 1]; ++e)
                for (int c = 0; c < a.width; ++c)
                    piece[std::size_t(i - first) * stride + start[a.block[e]] + c] = a.values[e][c];
        MatrixLoops<isa>::add_gram(piece.data(), last - first, int(place.size()), place.data(), g.triangle());
    }
}

}  // namespace

Columns::Columns(const BlockMatrix& a) : blocks(std::size_t(a.blocks)) {
    for (int i = 0; i < a.rows; ++i)
        for (int e = a.first[i]; e < a.first[i + 1]; ++e) blocks[a.block[e]].push_back({i, a.values[e]});
}

std::vector<std::int32_t> rows_of(const std::vector<Columns::Entry>& entries) {
    std::vector<std::int32_t> rows;
    for (const Columns::Entry& e : entries) rows.push_back(e.row);
    return rows;
}

Buffer<double> transposed(const std::vector<Columns::Entry>& entries, int first, int count) {
    const int stride = padded(int(entries.size()));
    Buffer<double> b(std::size_t(count) * stride);
    for (std::size_t i = 0; i < entries.size(); ++i)
        for (int c = 0; c < count; ++c) b[std::size_t(c) * stride + i] = entries[i].values[first + c];
    return b;
}

Gram::Gram(const BlockMatrix& a, const Columns& columns, Isa isa)
    : size(std::min(a.rows, a.columns())),
      stride(padded(size) + lanes),
      of_rows(a.rows <= a.columns()),
      values(std::size_t(padded(size)) * stride) {
    dispatch(isa, [&](auto set) {
        if (of_rows)
            add_rows_gram<decltype(set)::value>(a, columns, *this);
        else
            add_columns_gram<decltype(set)::value>(a, *this);
    });
    // Sums fill the lower triangle; the diagonal's blocks have to be whole.
    for (int i = 0; i < size; ++i)
        for (int j = i / lanes * lanes; j < i; ++j)
            values[std::size_t(j) * stride + i] = values[std::size_t(i) * stride + j];
}

}  // namespace plumb::probes
