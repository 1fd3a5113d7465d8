#include <cstddef>

#include "core/number.h"
#include "gi/probes/svd_loops.h"

namespace plumb::probes {

namespace {

// Eight doubles, in as many registers as the instruction set needs for them.
#if defined(__AVX512F__)
constexpr int width = 8;
#elif defined(__AVX2__)
constexpr int width = 4;
#else
constexpr int width = 2;
#endif
using Register = double __attribute__((vector_size(8 * width)));

struct Lanes {
    Register part[lanes / width];

    double operator[](int i) const { return part[i / width][i % width]; }
    // As a function of the parts of the operands.
    template <class F>
    static PLUMB_INLINE Lanes of(F f) {
        Lanes x;
#pragma GCC unroll 4
        for (int i = 0; i < lanes / width; ++i) x.part[i] = f(i);
        return x;
    }
    friend PLUMB_INLINE Lanes operator+(const Lanes& a, const Lanes& b) {
        return of([&](int i) { return a.part[i] + b.part[i]; });
    }
    friend PLUMB_INLINE Lanes operator-(const Lanes& a, const Lanes& b) {
        return of([&](int i) { return a.part[i] - b.part[i]; });
    }
    friend PLUMB_INLINE Lanes operator*(const Lanes& a, const Lanes& b) {
        return of([&](int i) { return a.part[i] * b.part[i]; });
    }
    friend PLUMB_INLINE Lanes operator*(double a, const Lanes& b) {
        return of([&](int i) { return a * b.part[i]; });
    }
};

PLUMB_INLINE Lanes load(const double* p) {
    return Lanes::of([&](int i) {
        Register r;
        __builtin_memcpy(&r, p + i * width, sizeof r);
        return r;
    });
}
PLUMB_INLINE void save(double* p, const Lanes& x) {
#pragma GCC unroll 4
    for (int i = 0; i < lanes / width; ++i) __builtin_memcpy(p + i * width, &x.part[i], sizeof(Register));
}
PLUMB_INLINE double sum(const Lanes& x) { return ((x[0] + x[4]) + (x[2] + x[6])) + ((x[1] + x[5]) + (x[3] + x[7])); }

constexpr int tile_rows = 4;

// tile[i] = sum of k x[k][i] y[k][0..7], ascending.
PLUMB_INLINE void multiply_tile(const double* x, int x_stride, const double* y, int y_stride, int rows,
                                Lanes (&tile)[tile_rows]) {
    Lanes a{}, b{}, c{}, d{};
    for (int k = 0; k < rows; ++k, x += x_stride, y += y_stride) {
        const Lanes right = load(y);
        a = a + x[0] * right, b = b + x[1] * right, c = c + x[2] * right, d = d + x[3] * right;
    }
    tile[0] = a, tile[1] = b, tile[2] = c, tile[3] = d;
}

// One row of a tile to the columns place[0..count) of a row.
PLUMB_INLINE void scatter(Lanes tile, const std::int32_t* place, int count, double* row) {
    if (count == lanes && place[lanes - 1] - place[0] == lanes - 1) {
        double* p = row + place[0];
        return save(p, load(p) + tile);
    }
    for (int j = 0; j < count; ++j) row[place[j]] += tile[j];
}

// Four rows, below the diagonal's blocks: takes the update, multiplies by v from both sides.
PLUMB_INLINE void update_four(double* g, int stride, int columns, int row, const double* u, const double* w,
                              const double* v, double* y) {
    const double u0 = u[row], u1 = u[row + 1], u2 = u[row + 2], u3 = u[row + 3];
    const double w0 = w[row], w1 = w[row + 1], w2 = w[row + 2], w3 = w[row + 3];
    const double v0 = v[row], v1 = v[row + 1], v2 = v[row + 2], v3 = v[row + 3];
    double *g0 = g, *g1 = g0 + stride, *g2 = g1 + stride, *g3 = g2 + stride;
    Lanes s0{}, s1{}, s2{}, s3{};
    for (int c = 0; c < columns; c += lanes) {
        const Lanes uc = load(u + c), wc = load(w + c), vc = load(v + c);
        const Lanes a0 = load(g0 + c) - (u0 * wc + w0 * uc), a1 = load(g1 + c) - (u1 * wc + w1 * uc);
        const Lanes a2 = load(g2 + c) - (u2 * wc + w2 * uc), a3 = load(g3 + c) - (u3 * wc + w3 * uc);
        save(g0 + c, a0), save(g1 + c, a1), save(g2 + c, a2), save(g3 + c, a3);
        save(y + c, (((load(y + c) + v0 * a0) + v1 * a1) + v2 * a2) + v3 * a3);
        s0 = s0 + a0 * vc, s1 = s1 + a1 * vc, s2 = s2 + a2 * vc, s3 = s3 + a3 * vc;
    }
    y[row] += sum(s0), y[row + 1] += sum(s1), y[row + 2] += sum(s2), y[row + 3] += sum(s3);
}

}  // namespace

template <>
void MatrixLoops<Isa::PLUMB_ISA>::add_gram(const double* b, int rows, int columns, const std::int32_t* place,
                                           Triangle g) {
    const int stride = padded(columns);
    for (int j = 0; j < columns; j += lanes)
        for (int i = j; i < columns; i += tile_rows) {
            Lanes tile[tile_rows];
            multiply_tile(b + i, stride, b + j, stride, rows, tile);
            for (int r = 0; r < tile_rows && i + r < columns; ++r) {
                const int count = i + r - j + 1 < lanes ? i + r - j + 1 : lanes;
                scatter(tile[r], place + j, count, g.values + std::ptrdiff_t(place[i + r]) * g.stride);
            }
        }
}

template <>
void MatrixLoops<Isa::PLUMB_ISA>::add_product(const double* x, int m, const double* y, int n, int rows,
                                              const std::int32_t* place, double* c, int stride) {
    for (int i = 0; i < m; i += tile_rows)
        for (int j = 0; j < n; j += lanes) {
            Lanes tile[tile_rows];
            multiply_tile(x + i, padded(m), y + j, n, rows, tile);
            for (int r = 0; r < tile_rows && i + r < m; ++r) {
                double* p = c + std::ptrdiff_t(place ? place[i + r] : i + r) * stride + j;
                save(p, load(p) + tile[r]);
            }
        }
}

template <>
void MatrixLoops<Isa::PLUMB_ISA>::update_and_multiply(Triangle g, int blocks, const double* u, const double* w,
                                                      const double* v, double* y) {
    for (int c = 0; c < blocks * lanes; ++c) y[c] = 0;
    for (int b = 0; b < blocks; ++b) {
        const int first = b * lanes;
        double* row = g.values + std::ptrdiff_t(first) * g.stride;
        update_four(row, g.stride, first, first, u, w, v, y);
        update_four(row + std::ptrdiff_t(4) * g.stride, g.stride, first, first + 4, u, w, v, y);
        // The diagonal's block is whole: from one side only.
        const Lanes uc = load(u + first), wc = load(w + first);
        Lanes yc = load(y + first);
        for (int r = 0; r < lanes; ++r, row += g.stride) {
            const Lanes a = load(row + first) - (u[first + r] * wc + w[first + r] * uc);
            save(row + first, a);
            yc = yc + v[first + r] * a;
        }
        save(y + first, yc);
    }
}

template <>
void MatrixLoops<Isa::PLUMB_ISA>::reflect(const double* v, int n, double beta, double* z, int columns) {
    for (int c = 0; c < columns; c += lanes) {
        Lanes s{};
        for (int i = 0; i < n; ++i) s = s + v[i] * load(z + std::ptrdiff_t(i) * columns + c);
        s = beta * s;
        for (int i = 0; i < n; ++i) {
            double* p = z + std::ptrdiff_t(i) * columns + c;
            save(p, load(p) - v[i] * s);
        }
    }
}

template <>
double MatrixLoops<Isa::PLUMB_ISA>::dot(const double* a, const double* b, int n) {
    Lanes s{};
    for (int i = 0; i < n; i += lanes) s = s + load(a + i) * load(b + i);
    return sum(s);
}

template <>
void MatrixLoops<Isa::PLUMB_ISA>::add_scaled(double* a, double factor, const double* b, int n) {
    for (int i = 0; i < n; i += lanes) save(a + i, load(a + i) + factor * load(b + i));
}

template <>
void MatrixLoops<Isa::PLUMB_ISA>::rotate(double* a, double* b, double cosine, double sine, int n) {
    for (int i = 0; i < n; i += lanes) {
        const Lanes x = load(a + i), y = load(b + i);
        save(a + i, cosine * x - sine * y);
        save(b + i, sine * x + cosine * y);
    }
}

}  // namespace plumb::probes
