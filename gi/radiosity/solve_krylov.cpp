// BiCGSTAB and conjugate gradients, by Eigen, which sees no matrix: an operator applies the rows to all three channels at
// once, as one system of three times as many unknowns, so that rows are decoded once for the three.
//
// Eigen's sums run over its own vectors, which are aligned, on one thread, in the order of the instruction set that the
// host's code is compiled for (SSE2): their bits are the same on every machine. A test holds their hash.
#include <algorithm>
#include <cmath>
#include <Eigen/IterativeLinearSolvers>

#include "core/parallel.h"
#include "gi/radiosity/solve_problem.h"

namespace plumb::radiosity {

struct KrylovOperator;

}  // namespace plumb::radiosity

namespace Eigen::internal {

template <>
struct traits<plumb::radiosity::KrylovOperator> : traits<SparseMatrix<double>> {};

}  // namespace Eigen::internal

namespace plumb::radiosity {

using Vector = Eigen::VectorXd;  // [element][channel], scaled

// What Eigen asks of a matrix that is none.
struct KrylovOperator : Eigen::EigenBase<KrylovOperator> {
    using Scalar = double;
    using RealScalar = double;
    using StorageIndex = int;
    enum {
        ColsAtCompileTime = Eigen::Dynamic,
        RowsAtCompileTime = Eigen::Dynamic,
        MaxColsAtCompileTime = Eigen::Dynamic,
        IsRowMajor = false
    };

    Eigen::Index size = 0;
    std::function<void(const Vector& x, Vector& y)> apply;

    Eigen::Index rows() const { return size; }
    Eigen::Index cols() const { return size; }
    template <class Rhs>
    Eigen::Product<KrylovOperator, Rhs, Eigen::AliasFreeProduct> operator*(const Eigen::MatrixBase<Rhs>& x) const {
        return {*this, x.derived()};
    }
};

}  // namespace plumb::radiosity

namespace Eigen::internal {

template <class Rhs>
struct generic_product_impl<plumb::radiosity::KrylovOperator, Rhs, SparseShape, DenseShape, GemvProduct>
    : generic_product_impl_base<plumb::radiosity::KrylovOperator, Rhs,
                                generic_product_impl<plumb::radiosity::KrylovOperator, Rhs>> {
    template <class Dest>
    static void scaleAndAddTo(Dest& to, const plumb::radiosity::KrylovOperator& a, const Rhs& x, double factor) {
        const VectorXd in = x;
        VectorXd out(a.rows());
        a.apply(in, out);
        to += factor * out;
    }
};

}  // namespace Eigen::internal

namespace plumb::radiosity {

namespace {

// Changes nothing, but is shown the residual in each iteration.
struct Onlooker {
    std::function<void(const Vector&)> look;

    template <class Matrix>
    Onlooker& analyzePattern(const Matrix&) { return *this; }
    template <class Matrix>
    Onlooker& factorize(const Matrix&) { return *this; }
    template <class Matrix>
    Onlooker& compute(const Matrix&) { return *this; }
    const Vector& solve(const Vector& residual) const {
        if (look) look(residual);
        return residual;
    }
    Eigen::ComputationInfo info() { return Eigen::Success; }
};

template <class EigenSolver>
Vector run(const KrylovOperator& a, const Vector& right, double tolerance, int iterations,
           const std::function<void(const Vector&)>& look) {
    EigenSolver solver;
    solver.preconditioner().look = look;
    solver.compute(a);
    solver.setTolerance(tolerance);
    solver.setMaxIterations(iterations);
    return solver.solve(right);
}

// y - A y = r of an operator, in scaled unknowns, whose norm is that of the radiosities (README.md).
struct Krylov {
    Problem& problem;
    const SolveParams& params;
    KrylovOperator a;
    bool symmetric, exact;                             // exact: products are good to doubles
    std::function<glm::dvec3(const Vector&)> norm_of;  // of the radiosities that y stands for, by channel
    Solution s;
    std::string why;
    glm::dvec3 rounding{0};  // of the products that left the residual

    // By channel.
    glm::dvec3 norm(const Vector& y) const {
        glm::dvec3 sum(0);
        for (int i = 0; i < problem.count; ++i)
            for (int c = 0; c < 3; ++c) sum[c] += y[3 * i + c] * y[3 * i + c];
        return {std::sqrt(sum.x), std::sqrt(sum.y), std::sqrt(sum.z)};
    }
    void look(const glm::dvec3& left, const glm::dvec3& of, double power) {
        s.residual = relative(left, of);
        s.error = estimated_error(s.residual + relative(rounding, of), s.radius);
        s.curve.push_back({problem.products, s.residual, 0, s.error, power});
        problem.report(s.error, params.tolerance);
    }

    // Solves for `right`, then for what is left of it. `base`: the norm that the result has at least.
    Vector solve(const Vector& right, const glm::dvec3& base);

  private:
    Vector once(const Vector& left, const glm::dvec3& of);
};

// One run of Eigen's. Channels are scaled to the same size, so that one without much light is solved as well.
Vector Krylov::once(const Vector& left, const glm::dvec3& of) {
    const glm::dvec3 size = norm(left);
    Vector right(left.size());
    for (Eigen::Index i = 0; i < left.size(); ++i) right[i] = size[i % 3] > 0 ? left[i] / size[i % 3] : 0;

    double tolerance = 0.25;
    for (int c = 0; c < 3; ++c)
        if (size[c] > 0) tolerance = std::min(tolerance, params.tolerance * (1 - s.radius.high) * of[c] / size[c]);
    // Each channel's right side has the norm 1. Rounded products cannot do more than so much at a time.
    tolerance = std::max(0.5 * tolerance, exact ? 1e-14 : 1e-5);

    // BiCGSTAB shows its direction first, then a residual, in turns.
    int shown = 0;
    const auto look = [&](const Vector& r) {
        if (!symmetric && ++shown % 2) return;
        const glm::dvec3 n = norm(r);
        this->look(n * size, of, 0);
    };
    const int most = std::max(1, int((params.most_products - problem.products) / (symmetric ? 1 : 2)));
    Vector d = symmetric ? run<Eigen::ConjugateGradient<KrylovOperator, Eigen::Lower | Eigen::Upper, Onlooker>>(
                               a, right, tolerance, most, look)
                         : run<Eigen::BiCGSTAB<KrylovOperator, Onlooker>>(a, right, tolerance, most, look);
    for (Eigen::Index i = 0; i < d.size(); ++i) d[i] *= size[i % 3];
    return d;
}

Vector Krylov::solve(const Vector& right, const glm::dvec3& base) {
    Vector y = Vector::Zero(right.size()), left = right, change(right.size());
    glm::dvec3 of = base;
    for (double last = HUGE_VAL; problem.products < params.most_products;) {
        const Vector d = once(left, of);
        if (!d.allFinite()) {
            why = "broke down";
            break;
        }
        a.apply(d, change);
        if (!exact) rounding += problem.rounding;
        y += d, left -= change;
        of = norm_of(y);
        look(norm(left), of, 0);
        if (s.error <= params.tolerance || s.residual == 0) break;
        if (!(s.residual < 0.5 * last) || s.residual < 0.1 * relative(rounding, of)) {
            why = "no nearer: products are rounded";
            break;
        }
        last = s.residual;
    }
    return y;
}

}  // namespace

Solution solve_bicgstab(Problem& problem, const SolveParams& params) {
    const int n = problem.count;
    Krylov krylov{problem, params, {}, false, bool(problem.transport.gather_double), {}, {}, "all products done", {}};
    krylov.s.radius = power_iteration(problem, std::min(64, params.most_products));

    // y = w B, w the root of the norm's weight.
    std::vector<double> w;
    for (double weight : problem.weight) w.push_back(std::sqrt(weight));
    Channels b(n, glm::dvec3(0)), t;
    krylov.a.size = 3 * Eigen::Index(n);
    krylov.a.apply = [&](const Vector& x, Vector& y) {
        for (int i = 0; i < n; ++i)
            for (int c = 0; c < 3; ++c) b[i][c] = x[3 * i + c] / w[i];
        problem.times(b, t);
        for (int i = 0; i < n; ++i)
            for (int c = 0; c < 3; ++c) y[3 * i + c] = x[3 * i + c] - w[i] * t[i][c];
    };
    krylov.norm_of = [&](const Vector& y) { return krylov.norm(y); };

    Vector right(krylov.a.size);
    for (int i = 0; i < n; ++i)
        for (int c = 0; c < 3; ++c) right[3 * i + c] = w[i] * problem.emission[i][c];
    const Vector y = krylov.solve(right, problem.norm(problem.emission));

    Solution s = std::move(krylov.s);
    s.radiosity.resize(std::size_t(n));
    for (int i = 0; i < n; ++i)
        for (int c = 0; c < 3; ++c) s.radiosity[i][c] = y[3 * i + c] / w[i];
    s.row_residual = s.residual;
    finish(problem, params, krylov.why, s);
    return s;
}

// ---- Conjugate gradients --------------------------------------------------------------------------------------------

namespace {

// K = (A F + F^T A) / 2 + diag(e), one decoding of all rows a product. Rows are shared out to a fixed number of bands, whose sums
// are added in their order. e makes the sums of K's rows those of A F: averaged alone, rows of elements that others see larger than
// these see them would sum to more than one, and light would grow with each reflection.
class AveragedRows {
  public:
    explicit AveragedRows(Problem& problem) : problem_(problem), sums_(std::min(bands, problem.count)), kept_(std::size_t(problem.count), 0.0) {
        Channels ones(std::size_t(problem.count), glm::dvec3(1)), k;
        std::vector<double> row_sums(std::size_t(problem.count), 0.0);
        averaged(ones, k, row_sums.data());
        if (problem.transport.row_sums) row_sums = *problem.transport.row_sums;
        for (int i = 0; i < problem.count; ++i) kept_[std::size_t(i)] = problem.area[i] * row_sums[std::size_t(i)] - k[i].x;
    }

    void times(const Channels& x, Channels& y) {
        averaged(x, y, nullptr);
        for (int i = 0; i < problem_.count; ++i) y[i] += kept_[std::size_t(i)] * x[i];
    }

  private:
    // row_sums: of F, where they are asked for.
    void averaged(const Channels& x, Channels& y, double* row_sums) {
        const int n = problem_.count, band = (n + bands - 1) / bands;
        y.assign(std::size_t(n), glm::dvec3(0));
        for (Channels& sum : sums_) sum.assign(std::size_t(n), glm::dvec3(0));
        parallel_bands(n, band, problem_.options.threads, [&](int first, int last) {
            Channels& sum = sums_[first / band];
            std::vector<float> row;
            for (int i = first; i < last; ++i) {
                problem_.row(i, row);
                if (row_sums)
                    for (const float f : row) row_sums[i] += double(f);
                const glm::dvec3 out = 0.5 * problem_.area[i] * x[i];
                glm::dvec3 in(0);
                for (int j = 0; j < n; ++j) {
                    in += double(row[j]) * x[j];
                    sum[j] += double(row[j]) * out;
                }
                y[i] = 0.5 * problem_.area[i] * in;
            }
        });
        for (const Channels& sum : sums_)
            for (int i = 0; i < n; ++i) y[i] += sum[i];
        problem_.products += 1;
    }

    static constexpr int bands = 16;
    Problem& problem_;
    std::vector<Channels> sums_;
    std::vector<double> kept_;  // e, m2: what an element keeps, or returns
};

}  // namespace

Solution solve_conjugate_gradients(Problem& problem, const SolveParams& params) {
    const int n = problem.count;
    Krylov krylov{problem, params, {}, true, true, {}, {}, "all products done", {}};
    krylov.s.radius = power_iteration(problem, std::min(64, params.most_products));

    // X = B - M, what is reflected, is root(rho / A) y; rho = 0 leaves nothing of y.
    double all = 0;
    for (double a : problem.area) all += a;
    Channels scale(n, glm::dvec3(0)), x = scale, k;
    for (int i = 0; i < n; ++i)
        for (int c = 0; c < 3; ++c)
            if (problem.area[i] > 0) scale[i][c] = std::sqrt(problem.reflectance[i][c] / problem.area[i]);
    AveragedRows rows(problem);
    const auto reflected = [&](const Vector& y) {
        for (int i = 0; i < n; ++i)
            for (int c = 0; c < 3; ++c) x[i][c] = scale[i][c] * y[3 * i + c];
    };
    krylov.a.size = 3 * Eigen::Index(n);
    krylov.a.apply = [&](const Vector& in, Vector& out) {
        reflected(in);
        rows.times(x, k);
        for (int i = 0; i < n; ++i)
            for (int c = 0; c < 3; ++c) out[3 * i + c] = in[3 * i + c] - scale[i][c] * k[i][c];
    };
    const double root = std::sqrt(std::max(all, 1e-300));  // norms are of means, y's are of sums
    krylov.norm_of = [&](const Vector& y) {
        reflected(y);
        for (int i = 0; i < n; ++i) x[i] += problem.exitance[i];
        return root * problem.norm(x);
    };

    rows.times(problem.exitance, k);
    Vector right(krylov.a.size);
    for (int i = 0; i < n; ++i)
        for (int c = 0; c < 3; ++c)
            right[3 * i + c] = scale[i][c] * (problem.area[i] * problem.incident[i][c] + k[i][c]);
    const Vector y = krylov.solve(right, root * problem.norm(problem.emission));

    Solution s = std::move(krylov.s);
    finish(problem, params, krylov.why, s);
    reflected(y);
    s.radiosity = std::move(x);
    for (int i = 0; i < n; ++i) s.radiosity[i] += problem.exitance[i];
    // Elements of no area are in no symmetric system: they gather.
    Channels rest = problem.residual(s.radiosity);
    for (int i = 0; i < n; ++i)
        if (problem.area[i] == 0) s.radiosity[i] += rest[i], rest[i] = glm::dvec3(0);
    s.row_residual = relative(problem.norm(rest), problem.norm(s.radiosity));
    return s;
}

}  // namespace plumb::radiosity
