// Singular values and leading singular vectors of a transport matrix, in double, with the same bits everywhere.
//
// The matrix' rows are sparse in blocks of columns: a receiver is supported by few of a cluster's probes. Eigenvalues
// of the Gram matrix of the smaller side give all singular values, its eigenvectors the leading ones (IPR 3.2.4.2).
// Squares lose what is small: a singular value below 2^-25 of the norm is known to that absolute error only.
// README.md bounds what this does to the error below.
#pragma once

#include <cstdint>
#include <vector>

#include "core/isa.h"

namespace plumb::probes {

// rows x (blocks * width). Row i has the entries first[i] .. first[i + 1] - 1, each of another block; values[] points
// at `width` finite floats, no larger than 1e36. A matrix without holes is one block.
struct BlockMatrix {
    int rows = 0, blocks = 0, width = 0;
    std::vector<std::int32_t> first = {0}, block;
    std::vector<const float*> values;

    int columns() const { return blocks * width; }
    void add_entry(int b, const float* v) { block.push_back(b), values.push_back(v); }
    void end_row() { ++rows, first.push_back(std::int32_t(block.size())); }
};

// A is approximately U (Sigma V^T): U's columns are orthonormal, and so are V's rows.
struct Svd {
    int rank = 0;                         // singular values kept
    std::vector<double> u;                // [rank][rows]: each vector's largest component (of equals the first) is > 0
    std::vector<double> sigma_vt;         // [rank][columns]
    std::vector<double> singular_values;  // all min(rows, columns), descending
    double sum_of_squares = 0;            // of A's values: |A|^2 in Frobenius norm
};

// 1 - sqrt(sum of the first `kept` / sum of all), as printed (IPR 3.2.4.2). No norm of an error. 0 of a zero matrix.
double published_error(const std::vector<double>& singular_values, int kept);
// sqrt(sum of squares beyond the first `kept` / sum of all squares): the share of |A| that truncation loses.
double frobenius_error(const std::vector<double>& singular_values, int kept);

// Seconds by step, added up over calls.
struct SvdSeconds {
    double gram = 0, tridiagonal = 0, eigenvalues = 0, vectors = 0, products = 0;
};

enum class Verdict { accepted, rejected, rejected_early };

// Decomposes, keeping at most `kept` singular values, of them those above 2^-40 of the largest. Rejects where the
// published error is not below most_error: `out` is then empty, and where a bound tells it, most of the work is saved.
Verdict truncated_svd(const BlockMatrix& a, int kept, double most_error, Isa isa, Svd& out,
                      SvdSeconds* seconds = nullptr);

}  // namespace plumb::probes
