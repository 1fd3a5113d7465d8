// Singular value decompositions of transport matrices: closed forms, Eckart and Young, Eigen's as the truth.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <Eigen/QR>
#include <Eigen/SVD>

#include "core/content_hasher.h"
#include "core/host_math.h"
#include "gi/probes/svd.h"
#include "gi/probes/tridiagonal.h"
#include "tests/gi/probe_transport.h"

using namespace plumb;
using namespace plumb::probes;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double never = 2;  // no error is as large: nothing is rejected

// A matrix of floats in blocks of columns; blocks that are 0 in a row are no entry of it.
struct Blocks {
    MatrixXd dense;
    std::vector<float> values;
    BlockMatrix matrix;

    Blocks(const MatrixXd& m, int width) : dense(m.cast<float>().cast<double>()) {
        const int rows = int(m.rows()), blocks = int(m.cols()) / width;
        values.resize(std::size_t(rows) * blocks * width);
        matrix.blocks = blocks, matrix.width = width;
        for (int i = 0; i < rows; ++i) {
            for (int b = 0; b < blocks; ++b) {
                float* entry = &values[(std::size_t(i) * blocks + b) * width];
                bool any = false;
                for (int c = 0; c < width; ++c) any |= (entry[c] = float(m(i, b * width + c))) != 0;
                if (any) matrix.add_entry(b, entry);
            }
            matrix.end_row();
        }
    }
    explicit Blocks(const MatrixXd& m) : Blocks(m, int(m.cols())) {}
    Blocks(const Blocks&) = delete;
};

MatrixXd random(int rows, int columns, int seed) {
    MatrixXd m(rows, columns);
    for (int i = 0; i < rows; ++i)
        for (int j = 0; j < columns; ++j) m(i, j) = hashed(i, j, seed) - 0.5;
    return m;
}
MatrixXd orthonormal(int rows, int columns, int seed) {
    return Eigen::HouseholderQR<MatrixXd>(random(rows, columns, seed)).householderQ() *
           MatrixXd::Identity(rows, columns);
}
// With these singular values; up to rounding to float.
MatrixXd with_values(int rows, int columns, const std::vector<double>& s, int seed) {
    const int k = int(s.size());
    const VectorXd values = Eigen::Map<const VectorXd>(s.data(), k);
    return orthonormal(rows, k, seed) * values.asDiagonal() * orthonormal(columns, k, seed + 1).transpose();
}
std::vector<double> powers(double q, int count) {
    std::vector<double> s(1, 1.0);
    while (int(s.size()) < count) s.push_back(s.back() * q);
    return s;
}
MatrixXd transport_matrix(const Transport& t, int probes) {
    MatrixXd m = MatrixXd::Zero(t.receivers, probes * t.coefficients);
    for (int i = 0; i < t.receivers; ++i)
        for (int s = 0; s < t.overlaps; ++s) {
            const std::size_t slot = std::size_t(i) * t.overlaps + s;
            if (t.support[slot] < 0) continue;
            for (int c = 0; c < t.coefficients; ++c)
                m(i, t.support[slot] * t.coefficients + c) = t.alpha[slot * t.coefficients + c];
        }
    return m;
}

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
MatrixXd left(const Svd& s, int rows) { return Eigen::Map<const RowMajor>(s.u.data(), s.rank, rows); }
MatrixXd right(const Svd& s, int columns) { return Eigen::Map<const RowMajor>(s.sigma_vt.data(), s.rank, columns); }

Svd decompose(const Blocks& a, int kept, Isa isa = best_isa()) {
    Svd s;
    REQUIRE(truncated_svd(a.matrix, kept, never, isa, s) == Verdict::accepted);
    return s;
}

double tail_of(const VectorXd& s, int kept) { return kept < s.size() ? s.tail(s.size() - kept).norm() : 0; }

// What holds for every decomposition. U and V are orthonormal; signs are as promised; what is kept is as near as any
// matrix of that rank can be (Eckart and Young 1936), to rounding; all values are Eigen's, those below 2^-23 of the
// first to 2^-23.
void require_decomposition(const Blocks& a, int kept, const VectorXd& truth) {
    const Svd s = decompose(a, kept);
    const int rows = a.matrix.rows, columns = a.matrix.columns();
    const double first = truth.size() ? truth[0] : 0, norm = a.dense.norm();
    const MatrixXd u = left(s, rows), w = right(s, columns);
    REQUIRE(int(s.singular_values.size()) == std::min(rows, columns));
    REQUIRE(s.rank <= kept);

    CHECK((u * u.transpose() - MatrixXd::Identity(s.rank, s.rank)).norm() <= 1e-12);
    const VectorXd sigma = Eigen::Map<const VectorXd>(s.singular_values.data(), s.rank);
    CHECK((w * w.transpose() - MatrixXd(sigma.cwiseAbs2().asDiagonal())).norm() <= 1e-11 * first * first);
    const MatrixXd v = sigma.cwiseInverse().asDiagonal() * w;
    CHECK((v * v.transpose() - MatrixXd::Identity(s.rank, s.rank)).norm() <= 1e-10);
    for (int i = 0; i < s.rank; ++i) {
        Eigen::Index largest;
        u.row(i).cwiseAbs().maxCoeff(&largest);
        CHECK(u(i, largest) > 0);
        CHECK(w.row(i).norm() == Approx(sigma[i]).epsilon(1e-12));
    }
    for (std::size_t i = 1; i < s.singular_values.size(); ++i)
        REQUIRE(s.singular_values[i] <= s.singular_values[i - 1]);

    double off = 0;
    for (int i = 0; i < truth.size(); ++i) {
        const double allowed = truth[i] > 0x1p-20 * first ? 1e-13 * first * first / truth[i] : 0x1p-23 * first;
        off = std::max(off, std::fabs(s.singular_values[i] - truth[i]) / (allowed + 1e-300));
    }
    CHECK(off <= 1);

    const double tail = tail_of(truth, kept), error = (a.dense - u.transpose() * w).norm();
    CHECK(error <= 1.0001 * tail + 0x1p-25 * norm);
    CHECK(error >= tail - 1e-13 * norm);
    CHECK(s.sum_of_squares == Approx(norm * norm).epsilon(1e-12));
}

VectorXd eigen_values(const MatrixXd& m) { return Eigen::BDCSVD<MatrixXd>(m).singularValues(); }
std::vector<double> eigen_spectrum(const MatrixXd& m) {
    const VectorXd s = eigen_values(m);
    return {s.begin(), s.end()};
}
void require_decomposition(const Blocks& a, int kept) { require_decomposition(a, kept, eigen_values(a.dense)); }

}  // namespace

TEST_CASE("tridiagonal: 2 and -1 have the eigenvalues 2 - 2 cos(k pi / (n + 1))", "[probes][analytic]") {
    for (int n : {1, 2, 3, 50, 700}) {
        CAPTURE(n);
        Tridiagonal t;
        t.size = n, t.trace = 2 * n;
        t.diagonal.assign(n, 2.0), t.off.assign(n, -1.0), t.off[n - 1] = 0;
        const std::vector<double> values = eigenvalues(t);
        REQUIRE(int(values.size()) == n);
        double off = 0;
        for (int k = 0; k < n; ++k)
            off = std::max(off, std::fabs(values[k] - (2 - 2 * host::cos((n - k) * host::pi / (n + 1)))));
        CHECK(off <= 1e-14 * std::sqrt(n) + 1e-15);
    }
}

TEST_CASE("published error: singular values q^i have 1 - sqrt((1 - q^32) / (1 - q^n))",
          "[probes][IPR 3.2.4.2][analytic]") {
    for (double q : {0.5, 0.85, 0.88, 0.99}) {
        CAPTURE(q);
        const double q_32 = host::pow(q, 32), q_300 = host::pow(q, 300);
        const double expected = 1 - std::sqrt((1 - q_32) / (1 - q_300));
        CHECK(published_error(powers(q, 300), 32) == Approx(expected).epsilon(1e-9).margin(1e-15));
        CHECK(frobenius_error(powers(q, 300), 32) ==
              Approx(std::sqrt((q_32 * q_32 - q_300 * q_300) / (1 - q_300 * q_300))).epsilon(1e-9));
    }
    // By hand from 0.85^32 = 0.0055134 and 0.88^32 = 0.0167277: half of them, and the next term.
    CHECK(published_error(powers(0.85, 300), 32) == Approx(0.0027605).epsilon(2e-4));
    CHECK(published_error(powers(0.88, 300), 32) == Approx(0.0083992).epsilon(2e-4));
    CHECK(published_error({}, 32) == 0);
    CHECK(published_error({0, 0, 0}, 2) == 0);
    CHECK(published_error({3, 1}, 2) == 0);
    CHECK(published_error({9, 7}, 1) == Approx(0.25));
    CHECK(frobenius_error({4, 3}, 1) == Approx(0.6));
    CHECK(frobenius_error({4e-200, 3e-200}, 1) == Approx(0.6));
}

TEST_CASE("svd: a matrix of singular values q^i is accepted for q = 0.85 and rejected for 0.88",
          "[probes][IPR 3.2.4.2][analytic]") {
    for (bool tall : {false, true}) {
        const int rows = tall ? 300 : 200, columns = tall ? 200 : 300;
        CAPTURE(rows, columns);
        const Blocks good(with_values(rows, columns, powers(0.85, 200), 1));
        const Blocks bad(with_values(rows, columns, powers(0.88, 200), 1));
        Svd s;
        CHECK(truncated_svd(good.matrix, 32, 0.005, best_isa(), s) == Verdict::accepted);
        // Floats carry the values to 2^-25 of the first, 200 of them.
        CHECK(published_error(s.singular_values, 32) == Approx(0.0027605).margin(2e-6));
        CHECK(truncated_svd(bad.matrix, 32, 0.005, best_isa(), s) != Verdict::accepted);
        CHECK((s.rank == 0 && s.u.empty() && s.sigma_vt.empty() && s.singular_values.empty()));
        CHECK(published_error(decompose(bad, 32).singular_values, 32) == Approx(0.0083992).margin(2e-6));
    }
}

TEST_CASE("svd: at full rank the matrix itself, from JacobiSVD's values", "[probes]") {
    const int sizes[][2] = {{1, 1}, {1, 64}, {64, 1}, {2, 3}, {8, 8}, {9, 7}, {31, 200}, {200, 31}, {64, 64}};
    for (const auto& size : sizes) {
        CAPTURE(size[0], size[1]);
        const Blocks a(random(size[0], size[1], 3));
        require_decomposition(a, 64, Eigen::JacobiSVD<MatrixXd>(a.dense).singularValues());
        const Svd s = decompose(a, 64);
        CHECK((a.dense - left(s, size[0]).transpose() * right(s, size[1])).norm() <= 1e-13 * a.dense.norm());
    }
}

TEST_CASE("svd: what is cut off is the tail of the singular values, of noise and of decaying values",
          "[probes][analytic]") {
    for (int kept : {4, 32, 64}) {
        CAPTURE(kept);
        require_decomposition(Blocks(random(150, 400, 5)), kept);
        require_decomposition(Blocks(random(400, 150, 6)), kept);
        require_decomposition(Blocks(with_values(120, 500, powers(0.9, 120), 7)), kept);
        require_decomposition(Blocks(with_values(500, 120, powers(0.5, 60), 8)), kept);
    }
}

TEST_CASE("svd: transport, sparse in its probes", "[probes][IPR figure 3.21]") {
    for (int coefficients : {1, 4, 64}) {
        CAPTURE(coefficients);
        for (double noise : {0.0, 0.1}) {
            const Transport t = smooth_transport(333, 20, coefficients, noise);
            const Blocks a(transport_matrix(t, 20), coefficients);
            require_decomposition(a, 32);
            // Where blocks end changes nothing but the order of sums.
            const Blocks whole(a.dense);
            const Svd s = decompose(a, 32), w = decompose(whole, 32);
            CHECK((left(s, 333).transpose() * right(s, a.matrix.columns()) -
                   left(w, 333).transpose() * right(w, a.matrix.columns()))
                      .norm() <= 1e-9 * a.dense.norm());
        }
    }
}

TEST_CASE("svd: values that are equal or nearly so", "[probes]") {
    // Vectors of equal values are any basis of their space: reconstruction is compared, not vectors.
    std::vector<double> steps, near, pairs, cut;
    for (int i = 0; i < 80; ++i) {
        steps.push_back(i < 20 ? 1 : i < 50 ? 0.5 : 0.01);
        near.push_back(1 - 1e-9 * i);
        pairs.push_back(1.0 / (1 + i / 2));
        cut.push_back(i < 31 ? 1 : i < 34 ? 0.25 : 1e-4);  // the cut at 32 goes through three equal ones
    }
    for (const auto& values : {steps, near, pairs, cut}) {
        require_decomposition(Blocks(with_values(90, 300, values, 11)), 32);
        require_decomposition(Blocks(with_values(300, 90, values, 12)), 32);
    }
    // Exactly equal, and exactly 0.
    require_decomposition(Blocks(MatrixXd::Identity(100, 100)), 32);
    require_decomposition(Blocks(MatrixXd::Identity(100, 250)), 64);
    MatrixXd islands = MatrixXd::Zero(120, 120);
    for (int b = 0; b < 4; ++b) islands.block(30 * b, 30 * b, 30, 30) = random(30, 30, 4);
    require_decomposition(Blocks(islands, 30), 32);
}

TEST_CASE("svd: of less rank than it has rows", "[probes]") {
    for (int rank : {1, 5, 31, 33}) {
        CAPTURE(rank);
        MatrixXd m = random(rank, 200, 21);
        MatrixXd wide(150, 200);
        for (int i = 0; i < 150; ++i) wide.row(i) = m.row(i % rank) * double(1 << i % 3);  // exact in float
        for (const MatrixXd& a : {wide, MatrixXd(wide.transpose())}) {
            require_decomposition(Blocks(a), 32);
            const Svd s = decompose(Blocks(a), 32);
            CHECK(s.rank == std::min(rank, 32));
            if (rank <= 32) CHECK(published_error(s.singular_values, 32) == 0);
        }
    }
    MatrixXd same(500, 64);
    for (int i = 0; i < 500; ++i) same.row(i) = random(1, 64, 22);
    const Svd s = decompose(Blocks(same), 32);
    CHECK(s.rank == 1);
    CHECK(s.singular_values[0] == Approx(std::sqrt(500.0) * random(1, 64, 22).cast<float>().norm()).epsilon(1e-6));
}

TEST_CASE("svd: zeros", "[probes][extreme]") {
    for (int rows : {1, 5, 100}) {
        const Blocks zero(MatrixXd::Zero(rows, 40), 4);
        Svd s;
        CHECK(truncated_svd(zero.matrix, 32, 0.005, best_isa(), s) == Verdict::accepted);
        CHECK(s.rank == 0);
        CHECK(s.u.empty());
        CHECK(s.singular_values == std::vector<double>(std::size_t(std::min(rows, 40)), 0.0));
        CHECK(published_error(s.singular_values, 32) == 0);
    }
    MatrixXd one = MatrixXd::Zero(100, 200);
    one(57, 133) = -3;
    const Svd s = decompose(Blocks(one, 10), 32);
    REQUIRE(s.rank == 1);
    CHECK(s.u[57] == 1);  // the sign
    CHECK(s.sigma_vt[133] == -3);

    // Of components that are equal the first is positive: sqrt(2) * (1, -1) / sqrt(2).
    const Svd equal = decompose(Blocks((MatrixXd(2, 1) << -1, 1).finished()), 32);
    REQUIRE(equal.rank == 1);
    CHECK(equal.u[0] > 0);
    CHECK(equal.u[0] == -equal.u[1]);
    CHECK(equal.sigma_vt[0] == Approx(-std::sqrt(2.0)).epsilon(1e-15));
}

TEST_CASE("svd: powers of two scale the values and leave U as it is, from 1e-30 to 1e+30", "[probes][extreme]") {
    const MatrixXd m = random(90, 160, 31);
    const Svd one = decompose(Blocks(m), 32);
    for (int exponent : {-100, 100}) {
        const Svd s = decompose(Blocks(m * std::ldexp(1.0, exponent)), 32);
        CHECK(s.u == one.u);
        for (int i = 0; i < 90; ++i) CHECK(s.singular_values[i] == std::ldexp(one.singular_values[i], exponent));
    }
    require_decomposition(Blocks(m * 1e30), 32);
    require_decomposition(Blocks(m * 1e-30), 32);
    // Rows of 1e+30 beside rows of 1e-30: the small ones are below all rounding.
    MatrixXd mixed = m * 1e30;
    mixed.bottomRows(45) = m.bottomRows(45) * 1e-30;
    require_decomposition(Blocks(mixed), 32);
}

TEST_CASE("svd: rejection is what the error of the whole decomposition says, early or not", "[probes]") {
    int early = 0;
    for (int kind = 0; kind < 4; ++kind) {
        const Transport t = smooth_transport(500, 24, 16, kind == 1 ? 0.02 : 0);
        const Blocks a(kind < 2    ? transport_matrix(t, 24)
                       : kind == 2 ? with_values(400, 500, powers(0.97, 400), 41)
                                   : random(500, 300, 42));
        const double error = published_error(decompose(a, 32).singular_values, 32);
        CAPTURE(kind, error);
        REQUIRE(error > 0);
        Svd s;
        CHECK(truncated_svd(a.matrix, 32, error, best_isa(), s) != Verdict::accepted);  // below, not at
        for (double factor : {0.01, 0.5, 0.9, 0.999, 0.9999999, 1.0000001, 1.001, 1.1, 2.0}) {
            CAPTURE(factor);
            const Verdict verdict = truncated_svd(a.matrix, 32, factor * error, best_isa(), s);
            CHECK((verdict == Verdict::accepted) == (factor > 1));
            early += verdict == Verdict::rejected_early;
        }
    }
    CHECK(early >= 4);

    // Two islands: the reduction begins in the second, of noise, where 32 values are not enough; all weight is in the
    // first.
    MatrixXd islands = MatrixXd::Zero(230, 400);
    islands.block(0, 0, 30, 200) = 100 * random(30, 200, 43);
    islands.block(30, 200, 200, 200) = 0.01 * random(200, 200, 44);
    const Blocks a(islands, 200);
    CHECK(published_error(eigen_spectrum(a.dense), 32) < 0.01);
    Svd s;
    CHECK(truncated_svd(a.matrix, 32, 0.01, best_isa(), s) == Verdict::accepted);
}

TEST_CASE("svd: the same bits on every instruction set", "[probes][bits]") {
    const Transport t = smooth_transport(201, 17, 16, 0.01);
    for (const MatrixXd& m : {transport_matrix(t, 17), MatrixXd(random(300, 77, 51)), MatrixXd(random(77, 300, 52))}) {
        const Blocks a(m, m.cols() == 17 * 16 ? 16 : int(m.cols()));
        const Svd first = decompose(a, 32, Isa::scalar);
        for (Isa isa : supported_isas()) {
            CAPTURE(isa_name(isa));
            const Svd s = decompose(a, 32, isa);
            CHECK(s.u == first.u);
            CHECK(s.sigma_vt == first.sigma_vt);
            CHECK(s.singular_values == first.singular_values);
        }
    }
}
