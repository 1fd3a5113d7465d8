// Eigenvalues and eigenvectors of symmetric positive semidefinite matrices by way of a tridiagonal one.
#pragma once

#include <functional>
#include <vector>

#include "core/image.h"
#include "core/isa.h"
#include "gi/probes/svd_loops.h"

namespace plumb::probes {

// T = H G H^T, H a product of reflections; in it `diagonal` and `off` (off[i] beside diagonal[i] and [i + 1]).
//
// Reduction goes from the last row up. It may end early: then `first` is the first row of T that was reached, and rows
// and columns before it hold a remainder of trace `rest` that T leaves out (diagonal and off are 0 there).
struct Tridiagonal {
    int size = 0, first = 0;
    double trace = 0, rest = 0;
    std::vector<double> diagonal, off;  // [size]; off[size - 1] is 0
    std::vector<double> beta;           // [size]: reflection i is 1 - beta v v^T, v in row i of the reduced matrix
};

// Reduces G (lower triangle, blocks of the diagonal whole, padded with zeros; size x stride) in place by Householder's
// reflections. Stops where `rest` is at most 2^-50 of the trace, the size of rounding, and where enough(T), asked after
// 64, 96, 128, 192 ... rows, says so.
Tridiagonal tridiagonalise(Triangle g, int size, Isa isa, const std::function<bool(const Tridiagonal&)>& enough = {});

// The eigenvalues of T's reached part, descending: QL without square roots (Pal, Walker and Kahan; Reinsch 1973).
// Absolute error: a few units in the last place of the largest.
std::vector<double> eigenvalues(const Tridiagonal& t);

// Orthonormal eigenvectors of G for the first `count` of T's eigenvalues, by inverse iteration, each orthogonal to
// those before: [size][padded(count)], contiguous, columns beyond count 0. g as tridiagonalise() left it.
Buffer<double> eigenvectors(const Tridiagonal& t, const std::vector<double>& values, int count, Triangle g, Isa isa);

}  // namespace plumb::probes
