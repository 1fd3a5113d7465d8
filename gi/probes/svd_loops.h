// The loops over matrices in which a singular value decomposition spends its time, compiled once an instruction set.
//
// Lanes run across the columns of a result, so that each value is one sum in ascending order; a dot product is eight
// such sums, of every eighth element, added as ((0+4)+(2+6))+((1+5)+(3+7)). So the bits are the same at any width.
// Matrices are row by row, `stride` doubles apart. Widths that are said to be padded are multiples of 8.
#pragma once

#include <cstdint>

#include "core/isa_name.h"

namespace plumb::probes {

inline constexpr int lanes = 8;

constexpr int padded(int n) { return (n + lanes - 1) / lanes * lanes; }

// A symmetric matrix, its lower triangle by rows: below the diagonal's blocks of 8 x 8, which are whole.
struct Triangle {
    double* values;
    int stride;
};

template <Isa isa>
struct MatrixLoops {
    // g[place[i]][place[j]] += sum of k b[k][i] b[k][j], for j <= i < columns; place ascends. b: rows x
    // padded(columns), 0 beyond columns.
    static void add_gram(const double* b, int rows, int columns, const std::int32_t* place, Triangle g);

    // c[place[i]][j] += sum of k x[k][i] y[k][j]. x: rows x padded(m), y: rows x padded n; place null: c[i].
    static void add_product(const double* x, int m, const double* y, int n, int rows, const std::int32_t* place,
                            double* c, int stride);

    // g -= u w^T + w u^T, then y = g v, for the rows and columns of `blocks` blocks of 8. All vectors are padded.
    static void update_and_multiply(Triangle g, int blocks, const double* u, const double* w, const double* v,
                                    double* y);

    // z -= beta v (v^T z): v of n, z of n x columns (padded, at most 64), contiguous.
    static void reflect(const double* v, int n, double beta, double* z, int columns);

    // n is padded, and so are the arrays.
    static double dot(const double* a, const double* b, int n);
    static void add_scaled(double* a, double factor, const double* b, int n);     // a += factor b
    static void rotate(double* a, double* b, double cosine, double sine, int n);  // (a, b) = (c a - s b, s a + c b)
};

}  // namespace plumb::probes
