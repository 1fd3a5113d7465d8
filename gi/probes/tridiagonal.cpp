#include "gi/probes/tridiagonal.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>

#include "core/hash.h"

namespace plumb::probes {

namespace {

constexpr double epsilon = 0x1p-53;
constexpr double rounding = 0x1p-50;  // of a trace: eight times what the sums of G leave of nothing

double trace_of(Triangle g, int rows) {
    double sum = 0;
    for (int i = 0; i < rows; ++i) sum += g.values[std::ptrdiff_t(i) * g.stride + i];
    return sum;
}

// Whether enough() is asked after that many rows: 64, 96, 128, 192, 256 ...
bool asked_after(int rows) {
    if (rows < 64) return false;
    while (rows % 2 == 0) rows /= 2;
    return rows == 1 || rows == 3;
}

// The reflection that takes x[0..n) to a multiple of its last axis: x becomes v. Returns beta, and the multiple.
double make_reflection(double* x, int n, double negligible, double& multiple) {
    double squares = 0;
    for (int i = 0; i < n; ++i) squares += x[i] * x[i];
    if (squares <= negligible) {
        std::fill_n(x, n, 0.0);
        multiple = 0;
        return 0;
    }
    const double length = std::sqrt(squares), last = x[n - 1];
    multiple = last > 0 ? -length : length;
    x[n - 1] = last - multiple;
    return 1 / (squares + length * std::fabs(last));
}

template <Isa isa>
void reduce(Triangle g, Tridiagonal& t, const std::function<bool(const Tridiagonal&)>& enough) {
    using Loops = MatrixLoops<isa>;
    const int width = padded(t.size);
    Buffer<double> u(width), w(width), v(width), y(width);  // the pending update is u w^T + w u^T
    // What is that small against the trace moves no eigenvalue by more than 2^-60 of it.
    const double negligible = 0x1p-120 * t.trace * t.trace;

    for (int i = t.size - 1; i >= 0; --i) {
        // Row i is brought up to date first, since the next reflection comes of it.
        double* row = g.values + std::ptrdiff_t(i) * g.stride;
        for (int c = 0; c <= i; ++c) row[c] -= u[i] * w[c] + w[i] * u[c];
        t.diagonal[i] = row[i];
        t.first = i;
        if (i == 0) break;
        t.beta[i] = make_reflection(row, i, negligible, t.off[i - 1]);
        std::copy_n(row, i, v.begin());
        std::fill(v.begin() + i, v.end(), 0.0);
        u[i] = w[i] = 0;
        Loops::update_and_multiply(g, padded(i) / lanes, u.data(), w.data(), v.data(), y.data());

        // A reflection leaves the trace as it is.
        t.rest = std::max(trace_of(g, i), 0.0);
        if (t.rest <= rounding * t.trace) break;
        if (enough && asked_after(t.size - i) && enough(t)) break;

        std::fill(y.begin() + i, y.begin() + padded(i), 0.0);
        const double beta = t.beta[i];
        const double half = 0.5 * beta * beta * Loops::dot(v.data(), y.data(), padded(i));
        for (int c = 0; c < i; ++c) w[c] = beta * y[c] - half * v[c];
        std::fill(w.begin() + i, w.end(), 0.0);
        std::swap(u, v);
    }
    if (t.first == 0)
        t.rest = 0;
    else
        t.off[t.first - 1] = 0;
}

// One sweep of QL without square roots over rows first..last; squares[i] is the square of off[i].
void sweep(std::vector<double>& d, std::vector<double>& squares, int first, int last) {
    // The shift: that eigenvalue of the upper 2 x 2 which is nearer its corner.
    const double root = std::sqrt(squares[first]);
    const double ratio = (d[first + 1] - d[first]) / (2 * root);
    const double length = std::sqrt(ratio * ratio + 1);
    const double shift = d[first] - root / (ratio + (ratio < 0 ? -length : length));

    double cosine = 1, sine = 0, gamma = d[last] - shift, p = gamma * gamma;
    for (int i = last - 1; i >= first; --i) {
        const double square = squares[i], r = p + square;
        if (i != last - 1) squares[i + 1] = sine * r;
        const double old_cosine = cosine, old_gamma = gamma;
        cosine = p / r;
        sine = square / r;
        gamma = cosine * (d[i] - shift) - sine * old_gamma;
        d[i + 1] = old_gamma + (d[i] - gamma);
        p = cosine != 0 ? gamma * gamma / cosine : old_cosine * square;
    }
    squares[first] = sine * p;
    d[first] = shift + gamma;
}

// T - shift = P L U, P exchanges of neighbouring rows; what solves with it.
struct Factors {
    std::vector<double> u0, u1, u2, l;
    std::vector<char> exchanged;

    // T's rows from t.first on, `scale` its size.
    Factors(const Tridiagonal& t, double shift, double scale) {
        const int n = t.size - t.first;
        u0.resize(n), u1.resize(n), u2.resize(n), l.resize(n), exchanged.resize(n);
        double pivot = t.diagonal[t.first] - shift, right = n > 1 ? t.off[t.first] : 0;
        for (int i = 0; i + 1 < n; ++i) {
            const double below = t.off[t.first + i], middle = t.diagonal[t.first + i + 1] - shift;
            const double next = i + 2 < n ? t.off[t.first + i + 1] : 0;
            exchanged[i] = std::fabs(below) > std::fabs(pivot);
            if (exchanged[i]) {
                l[i] = pivot / below;
                u0[i] = below, u1[i] = middle, u2[i] = next;
                pivot = right - l[i] * middle, right = -l[i] * next;
            } else {
                u0[i] = kept_from_0(pivot, scale), u1[i] = right, u2[i] = 0;
                l[i] = below / u0[i];
                pivot = middle - l[i] * right, right = next;
            }
        }
        u0[n - 1] = kept_from_0(pivot, scale);
    }

    static double kept_from_0(double pivot, double scale) {
        const double least = epsilon * scale;
        return std::fabs(pivot) >= least ? pivot : pivot < 0 ? -least : least;
    }

    void solve(double* x) const {
        const int n = int(u0.size());
        for (int i = 0; i + 1 < n; ++i) {
            if (exchanged[i]) std::swap(x[i], x[i + 1]);
            x[i + 1] -= l[i] * x[i];
        }
        for (int i = n - 1; i >= 0; --i) {
            double sum = x[i];
            if (i + 1 < n) sum -= u1[i] * x[i + 1];
            if (i + 2 < n) sum -= u2[i] * x[i + 2];
            x[i] = sum / u0[i];
        }
    }
};

// |(T - value) x|^2 of a unit vector.
double residual_squared(const Tridiagonal& t, double value, const double* x) {
    double sum = 0;
    for (int i = t.first; i < t.size; ++i) {
        double r = (t.diagonal[i] - value) * x[i - t.first];
        if (i > t.first) r += t.off[i - 1] * x[i - t.first - 1];
        if (i + 1 < t.size) r += t.off[i] * x[i - t.first + 1];
        sum += r * r;
    }
    return sum;
}

// Rows of `count` vectors of T, each orthogonal to those before it.
template <Isa isa>
Buffer<double> inverse_iteration(const Tridiagonal& t, const std::vector<double>& values, int count) {
    using Loops = MatrixLoops<isa>;
    const int n = t.size - t.first, width = padded(n);
    const double scale = std::max(values[0], t.trace * 0x1p-20);
    Buffer<double> vectors(std::size_t(count) * width);
    for (int j = 0; j < count; ++j) {
        double* x = vectors.data() + std::size_t(j) * width;
        const Factors factors(t, values[j], scale);
        for (int i = 0; i < n; ++i) x[i] = double(pixel_hash<std::int32_t>(i, j, 0, 1).x & 0xffff) - 32767.5;
        for (int round = 0; round < 6; ++round) {
            factors.solve(x);
            double largest = 0;
            for (int i = 0; i < n; ++i) largest = std::max(largest, std::fabs(x[i]));
            for (int i = 0; i < n; ++i) x[i] /= largest;
            for (int pass = 0; pass < 2; ++pass)
                for (int k = 0; k < j; ++k) {
                    const double* before = vectors.data() + std::size_t(k) * width;
                    Loops::add_scaled(x, -Loops::dot(before, x, width), before, width);
                }
            const double length = std::sqrt(Loops::dot(x, x, width));
            for (int i = 0; i < n; ++i) x[i] /= length;
            const double allowed = 4 * epsilon * scale;
            if (round > 0 && residual_squared(t, values[j], x) <= allowed * allowed) break;
        }
    }
    return vectors;
}

template <Isa isa>
Buffer<double> transformed_back(const Tridiagonal& t, const Buffer<double>& vectors, int count, Triangle g) {
    const int n = t.size - t.first, width = padded(n), columns = padded(count);
    Buffer<double> z(std::size_t(t.size) * columns);
    for (int j = 0; j < count; ++j)
        for (int i = 0; i < n; ++i) z[std::size_t(t.first + i) * columns + j] = vectors[std::size_t(j) * width + i];
    for (int i = std::max(t.first, 1); i < t.size; ++i)
        if (t.beta[i] != 0)
            MatrixLoops<isa>::reflect(g.values + std::ptrdiff_t(i) * g.stride, i, t.beta[i], z.data(), columns);
    return z;
}

}  // namespace

Tridiagonal tridiagonalise(Triangle g, int size, Isa isa, const std::function<bool(const Tridiagonal&)>& enough) {
    Tridiagonal t;
    t.size = size;
    t.diagonal.resize(size), t.off.resize(size), t.beta.resize(size);
    t.trace = trace_of(g, size);
    dispatch(isa, [&](auto set) { reduce<decltype(set)::value>(g, t, enough); });
    return t;
}

std::vector<double> eigenvalues(const Tridiagonal& t) {
    std::vector<double> d(t.diagonal.begin() + t.first, t.diagonal.end());
    std::vector<double> squares(d.size());
    for (std::size_t i = 0; i < d.size(); ++i) squares[i] = t.off[t.first + i] * t.off[t.first + i];
    const double small = 0x1p-56 * t.trace, negligible = small * small;

    const int size = int(d.size());
    for (int first = 0; first < size; ++first)
        for (int sweeps = 0;; ++sweeps) {
            int last = first;
            while (last + 1 < size && squares[last] > negligible) ++last;
            if (last == first) break;
            if (sweeps == 100) throw std::logic_error("QL does not converge");
            sweep(d, squares, first, last);
        }
    std::sort(d.begin(), d.end(), std::greater<>());
    return d;
}

Buffer<double> eigenvectors(const Tridiagonal& t, const std::vector<double>& values, int count, Triangle g, Isa isa) {
    return dispatch(isa, [&](auto set) {
        constexpr Isa chosen = decltype(set)::value;
        return transformed_back<chosen>(t, inverse_iteration<chosen>(t, values, count), count, g);
    });
}

}  // namespace plumb::probes
