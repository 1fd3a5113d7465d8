#include "gi/probes/svd.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>

#include "gi/probes/gram.h"
#include "gi/probes/tridiagonal.h"

namespace plumb::probes {

namespace {

// Adds the time since the last call, or since it was made.
class Watch {
  public:
    void add_to(double* seconds) {
        const auto now = std::chrono::steady_clock::now();
        if (seconds) *seconds += std::chrono::duration<double>(now - last_).count();
        last_ = now;
    }

  private:
    std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

// ---- Vectors of both sides ------------------------------------------------------------------------------------------

// `count` vectors, one after the other, each padded with zeros.
struct Vectors {
    int count, size, width;
    Buffer<double> values;

    Vectors(int n, int length) : count(n), size(length), width(padded(length)), values(std::size_t(n) * width) {}
    double* operator[](int i) { return values.data() + std::size_t(i) * width; }
    const double* operator[](int i) const { return values.data() + std::size_t(i) * width; }
};

// From [size][padded(count)].
Vectors turned(const Buffer<double>& z, int count, int size) {
    Vectors v(count, size);
    for (int j = 0; j < count; ++j)
        for (int i = 0; i < size; ++i) v[j][i] = z[std::size_t(i) * padded(count) + j];
    return v;
}

// A V, of V as eigenvectors() gives it.
template <Isa isa>
Vectors times_right(const BlockMatrix& a, const Columns& columns, const Buffer<double>& v, int count) {
    const int k = padded(count);
    Buffer<double> product(std::size_t(a.rows) * k);
    for (int p = 0; p < a.blocks; ++p) {
        const std::vector<std::int32_t> place = rows_of(columns.blocks[p]);
        for (int c = 0; c < a.width; c += band) {
            const int n = std::min(band, a.width - c);
            const Buffer<double> x = transposed(columns.blocks[p], c, n);
            const double* y = v.data() + (std::size_t(p) * a.width + c) * k;
            MatrixLoops<isa>::add_product(x.data(), int(place.size()), y, k, n, place.data(), product.data(), k);
        }
    }
    return turned(product, count, a.rows);
}

// U^T A.
template <Isa isa>
Vectors times_left(const BlockMatrix& a, const Columns& columns, const Vectors& u) {
    const int k = padded(u.count), width = padded(a.width);
    Vectors w(u.count, a.columns());
    for (int p = 0; p < a.blocks; ++p) {
        const auto& entries = columns.blocks[p];
        Buffer<double> x(entries.size() * k), y(entries.size() * width), c(std::size_t(u.count) * width);
        for (std::size_t e = 0; e < entries.size(); ++e) {
            for (int j = 0; j < u.count; ++j) x[e * k + j] = u[j][entries[e].row];
            for (int i = 0; i < a.width; ++i) y[e * width + i] = entries[e].values[i];
        }
        MatrixLoops<isa>::add_product(x.data(), u.count, y.data(), width, int(entries.size()), nullptr, c.data(),
                                      width);
        for (int j = 0; j < u.count; ++j)
            std::copy_n(c.data() + std::size_t(j) * width, a.width, w[j] + std::size_t(p) * a.width);
    }
    return w;
}

// Makes the vectors orthonormal in their order (Gram and Schmidt, twice); what is then below `least` is left out.
template <Isa isa>
void orthonormalise(Vectors& v, double least) {
    using Loops = MatrixLoops<isa>;
    int kept = 0;
    for (int j = 0; j < v.count; ++j) {
        if (kept != j) std::copy_n(v[j], v.width, v[kept]);
        double* x = v[kept];
        for (int pass = 0; pass < 2; ++pass)
            for (int k = 0; k < kept; ++k) Loops::add_scaled(x, -Loops::dot(v[k], x, v.width), v[k], v.width);
        const double length = std::sqrt(Loops::dot(x, x, v.width));
        if (!(length > least)) continue;
        for (int i = 0; i < v.size; ++i) x[i] /= length;
        ++kept;
    }
    v.count = kept;
    v.values.resize(std::size_t(kept) * v.width);
}

// Turns pairs of the rows of W = U^T A, and of U with them, until they are orthogonal (one-sided Jacobi): what the
// squares of the Gram matrix lost among the kept is found again.
template <Isa isa>
void make_orthogonal(Vectors& w, Vectors& u) {
    using Loops = MatrixLoops<isa>;
    constexpr double allowed = 0x1p-40;  // of the cosine between two rows
    for (int sweep = 0; sweep < 12; ++sweep) {
        bool turned = false;
        for (int i = 0; i < w.count; ++i)
            for (int j = i + 1; j < w.count; ++j) {
                const double a = Loops::dot(w[i], w[i], w.width), b = Loops::dot(w[j], w[j], w.width);
                const double c = Loops::dot(w[i], w[j], w.width);
                if (!(std::fabs(c) > allowed * std::sqrt(a) * std::sqrt(b))) continue;
                const double ratio = (b - a) / (2 * c);
                const double length = std::sqrt(1 + ratio * ratio);
                const double tangent = 1 / (ratio + (ratio < 0 ? -length : length));
                const double cosine = 1 / std::sqrt(1 + tangent * tangent);
                Loops::rotate(w[i], w[j], cosine, cosine * tangent, w.width);
                Loops::rotate(u[i], u[j], cosine, cosine * tangent, u.width);
                turned = true;
            }
        if (!turned) return;
    }
}

// ---- Together -------------------------------------------------------------------------------------------------------

double sum_of(const std::vector<double>& values, std::size_t first = 0) {
    double sum = 0;
    for (std::size_t i = values.size(); i > first; --i) sum += values[i - 1];  // the small ones first
    return sum;
}

std::vector<double> roots(std::vector<double> values) {
    for (double& v : values) v = std::sqrt(std::max(v, 0.0));
    return values;
}

// More than what the squares of the Gram matrix can do to the published error (README.md).
constexpr double slack = 0x1p-16;

// Whether the published error is above most_error whatever the rest holds. Of T's singular values s, A's are no
// smaller, and the sum of A's first `kept` is larger by sqrt(kept rest) at most.
bool surely_rejected(const Tridiagonal& t, int kept, double most_error) {
    const std::vector<double> s = roots(eigenvalues(t));
    if (int(s.size()) <= kept) return false;
    const double tail = sum_of(s, kept), head = sum_of(s) - tail + std::sqrt(kept * t.rest);
    return 1 - std::sqrt(head / (head + tail)) >= most_error + slack;
}

// Puts out what is kept, largest first, each with its sign. `spectrum` is the Gram matrix' view of all singular values.
// `wanted` vectors were looked for.
void keep(const Vectors& w, const Vectors& u, int wanted, std::vector<double> spectrum, const BlockMatrix& a,
          Svd& out) {
    std::vector<double> length(std::size_t(w.count));
    for (int j = 0; j < w.count; ++j) {
        double squares = 0;
        for (int i = 0; i < w.size; ++i) squares += w[j][i] * w[j][i];
        length[j] = std::sqrt(squares);
    }
    std::vector<int> order(length.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](int i, int j) { return length[i] > length[j]; });

    out.singular_values.clear();
    for (int j : order) {
        if (!(length[j] > 0x1p-40 * length[order[0]])) break;
        out.singular_values.push_back(length[j]);
        const double* vector = u[j];
        int largest = 0;
        for (int i = 1; i < a.rows; ++i)
            if (std::fabs(vector[i]) > std::fabs(vector[largest])) largest = i;
        const double sign = vector[largest] < 0 ? -1 : 1;
        for (int i = 0; i < a.rows; ++i) out.u.push_back(sign * vector[i]);
        for (int i = 0; i < w.size; ++i) out.sigma_vt.push_back(sign * w[j][i]);
    }
    out.rank = int(out.singular_values.size());
    // What was left out is no larger than what was kept, and nothing where all was kept.
    const double most = out.rank == wanted ? out.singular_values.back() : 0;
    spectrum.resize(std::size_t(std::min(a.rows, a.columns())));
    for (std::size_t i = std::size_t(out.rank); i < spectrum.size(); ++i)
        out.singular_values.push_back(std::min(spectrum[i], most));
}

template <Isa isa>
void find_vectors(const BlockMatrix& a, const Columns& columns, int kept, const Tridiagonal& t,
                  const std::vector<double>& values, Gram& g, Svd& out, SvdSeconds* seconds, Watch& watch) {
    const int count = std::min(kept, int(values.size()));
    const Buffer<double> z = eigenvectors(t, values, count, g.triangle(), isa);
    Vectors u = g.of_rows ? turned(z, count, a.rows) : times_right<isa>(a, columns, z, count);
    if (!g.of_rows) orthonormalise<isa>(u, 0x1p-40 * std::sqrt(values[0]));
    watch.add_to(seconds ? &seconds->vectors : nullptr);

    Vectors w = times_left<isa>(a, columns, u);
    make_orthogonal<isa>(w, u);
    keep(w, u, count, roots(values), a, out);
    watch.add_to(seconds ? &seconds->products : nullptr);
}

}  // namespace

double published_error(const std::vector<double>& singular_values, int kept) {
    const std::size_t n = std::min(singular_values.size(), std::size_t(kept));
    const double tail = sum_of(singular_values, n), all = sum_of(singular_values);
    // 1 - sqrt(1 - x), without the cancellation.
    const double x = all > 0 ? tail / all : 0;
    return x / (1 + std::sqrt(1 - x));
}

double frobenius_error(const std::vector<double>& singular_values, int kept) {
    std::vector<double> squares;
    const double largest = singular_values.empty() ? 0 : singular_values[0];
    if (largest == 0) return 0;
    for (double s : singular_values) squares.push_back((s / largest) * (s / largest));
    const std::size_t n = std::min(squares.size(), std::size_t(kept));
    return std::sqrt(sum_of(squares, n) / sum_of(squares));
}

Verdict truncated_svd(const BlockMatrix& a, int kept, double most_error, Isa isa, Svd& out, SvdSeconds* seconds) {
    out = {};
    Watch watch;
    const Columns columns(a);
    for (const float* v : a.values)
        for (int c = 0; c < a.width; ++c) out.sum_of_squares += double(v[c]) * v[c];

    Gram g(a, columns, isa);
    watch.add_to(seconds ? &seconds->gram : nullptr);

    bool early = false;
    auto enough = [&](const Tridiagonal& t) { return early = surely_rejected(t, kept, most_error); };
    const Tridiagonal t = tridiagonalise(g.triangle(), g.size, isa, enough);
    watch.add_to(seconds ? &seconds->tridiagonal : nullptr);
    if (early) return out = {}, Verdict::rejected_early;

    const std::vector<double> values = eigenvalues(t);
    watch.add_to(seconds ? &seconds->eigenvalues : nullptr);
    if (published_error(roots(values), kept) >= most_error + slack) return out = {}, Verdict::rejected;

    if (!values.empty() && values[0] > 0)
        dispatch(isa, [&](auto set) {
            find_vectors<decltype(set)::value>(a, columns, kept, t, values, g, out, seconds, watch);
        });
    else
        out.singular_values.assign(std::size_t(g.size), 0.0);
    if (published_error(out.singular_values, kept) >= most_error) return out = {}, Verdict::rejected;
    return Verdict::accepted;
}

}  // namespace plumb::probes
