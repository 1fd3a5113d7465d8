// Radiosity solvers against closed forms; numbers of verification.md, section 3, where nothing else is said.
#include <catch2/catch.hpp>
#include <Eigen/LU>

#include "core/error.h"
#include "gi/radiosity/solve.h"
#include "gi/radiosity/solve_audit.h"
#include "gi/radiosity/solve_choose.h"
#include "tests/gi/radiosity_systems.h"

using namespace plumb;
using namespace plumb::radiosity;
using Catch::Matchers::Contains;

namespace {

Solution passes(DenseSystem& s, int n) { return solved(s, Solver::passes, 0, n); }

// Largest relative difference of an element's channel.
double off(const std::vector<glm::dvec3>& b, const std::function<double(int, int)>& truth) {
    double worst = 0;
    for (int i = 0; i < int(b.size()); ++i)
        for (int c = 0; c < 3; ++c) {
            const double d = std::fabs(b[i][c] - truth(i, c)) / std::fabs(truth(i, c));
            worst = d <= worst ? worst : d;  // a NaN stays
        }
    return worst;
}
double off_cube(const Solution& s, float rho) {
    const std::array<double, 3> b = cube_radiosity(rho);
    return off(s.radiosity, [&](int i, int) { return b[std::min(i, 2)]; });
}

// Rows in floats, as a solver decodes them.
Eigen::MatrixXd rows_of(const DenseSystem& s, bool floats) {
    Eigen::MatrixXd f(s.n, s.n);
    for (int i = 0; i < s.n; ++i)
        for (int j = 0; j < s.n; ++j) f(i, j) = floats ? double(float(s.at(i, j))) : s.at(i, j);
    return f;
}
// By Eigen's LU with full pivoting, of the rows as they are.
std::vector<glm::dvec3> truth_of(const DenseSystem& s, const Eigen::MatrixXd& f) {
    std::vector<glm::dvec3> b(std::size_t(s.n), glm::dvec3(0));
    for (int c = 0; c < 3; ++c) {
        Eigen::VectorXd rho(s.n), e(s.n);
        for (int i = 0; i < s.n; ++i) rho[i] = s.reflectance[i][c], e[i] = s.exitance[i][c] + rho[i] * s.incident[i][c];
        const Eigen::VectorXd x =
            Eigen::FullPivLU<Eigen::MatrixXd>(Eigen::MatrixXd::Identity(s.n, s.n) - rho.asDiagonal() * f).solve(e);
        for (int i = 0; i < s.n; ++i) b[i][c] = x[i];
    }
    return b;
}
double off(const std::vector<glm::dvec3>& b, const std::vector<glm::dvec3>& truth) {
    REQUIRE(b.size() == truth.size());
    return off(b, [&](int i, int c) { return truth[i][c]; });
}

}  // namespace

TEST_CASE("radiosity: a cube of one element a face, the table", "[radiosity][HEM 4.5.4][analytic]") {
    struct Row { double rho, emitter, opposite, side; int passes; };
    for (const Row& r : {Row{0.5, 1.090909098, 0.181745826, 0.181836269, 21}, Row{0.8, 1.551724154, 0.689551071, 0.689681194, 63},
                         Row{0.95, 4.033613466, 3.193159845, 3.193306672, 271},
                         Row{0.99, 17.362270473, 16.527425128, 16.527576100, 1376}}) {
        CAPTURE(r.rho);
        const std::array<double, 3> b = cube_radiosity(r.rho);
        CHECK(std::fabs(b[0] - r.emitter) <= 6e-10);  // printed with nine digits
        CHECK(std::fabs(b[1] - r.opposite) <= 6e-10);
        CHECK(std::fabs(b[2] - r.side) <= 6e-10);

        const float rho = float(r.rho);
        DenseSystem s = cube_of_six(rho);
        for (Solver solver : all_solvers) {
            CAPTURE(solver_name(solver));
            // Solvers that ask for rows have them in floats: each 7.5e-9 off at most, a sum 3.8e-8.
            const bool rows = solver != Solver::passes && solver != Solver::bicgstab;
            const Solution x = solved(s, solver, 1e-11);
            CHECK(x.converged);
            CHECK(off_cube(x, rho) <= 2e-11 + (rows ? 4e-8 / (1 - r.rho) : 0));
        }
        // The mean is 1 / (6 (1 - rho)).
        double mean = 0;
        for (const glm::dvec3& v : solved(s, Solver::bicgstab, 1e-12).radiosity) mean += v.x / 6;
        CHECK(mean * 6 * (1 - double(rho)) == Approx(1).epsilon(1e-11));

        CHECK(off_cube(passes(s, r.passes), rho) <= 1e-6);
        CHECK(off_cube(passes(s, r.passes - 1), rho) > 1e-6);
    }
}

TEST_CASE("radiosity: a small step is no small error; the residual over 1 - radius is", "[radiosity][HEM 4.5.4][analytic]") {
    DenseSystem s = cube_of_six(0.99f);
    const Solution many = passes(s, 1000);
    int stopped = 0;  // where a step of 1e-6 of the largest radiosity would stop
    for (const CurvePoint& p : many.curve)
        if (!stopped && p.step * 16.67 <= 1e-6 * 17.362) stopped = int(p.products);
    CHECK(stopped >= 910);
    CHECK(stopped <= 915);
    const double error = off_cube(passes(s, stopped), 0.99f);
    CHECK(error > 0.9e-4);
    CHECK(error < 1.1e-4);

    // After a dozen passes the slow mode is alone: the estimate is the error. In the norm of the mean of squares: rho^n.
    const double rho = double(0.99f), odd = 0.5 / (1 + rho * opposite_square);
    const double even = 1 / (3 * (1 - rho * (opposite_square - 2 * adjacent_square)));
    double power = 1;
    for (const CurvePoint& p : many.curve) {
        power *= rho;
        if (p.products < 12) continue;
        const double mean = (1 - power) / (6 * (1 - rho)), rms = std::sqrt(mean * mean + odd * odd / 3 + even * even / 2);
        REQUIRE(p.error == Approx(power / (6 * (1 - rho)) / rms).epsilon(1e-6));
    }
    CHECK(many.radius.settled);
    CHECK(many.radius.value == Approx(double(0.99f)).epsilon(1e-9));
    CHECK(many.radius.high >= many.radius.value);
    CHECK(many.radius.high - many.radius.value <= 1e-9);
}

TEST_CASE("radiosity: pass n of a closed uniform scene is M (1 - rho^n) / (1 - rho)", "[radiosity][HEM 4.5.4][analytic]") {
    for (float rho : {0.5f, 0.99f, 0.999999f})
        for (Rounding rounding : {Rounding::none, Rounding::floats_about_mean}) {
            CAPTURE(rho, int(rounding));
            DenseSystem s = sphere(16, rho);
            s.exitance.assign(16, glm::vec4(1, 2, 0, 0));
            double power = 1, r = double(rho);
            for (int n : {1, 2, 3, 10, 100, 1000}) {
                const Solution x = solved(s, Solver::passes, 0, n, rounding);
                REQUIRE(int(x.curve.size()) == n);
                power = 1;
                for (int k = 0; k < n; ++k) power *= r;
                double sum = 0, term = 1;
                for (int k = 0; k < n; ++k) sum += term, term *= r;
                for (const glm::dvec3& b : x.radiosity) {
                    REQUIRE(b.x == Approx(sum).epsilon(1e-12));
                    REQUIRE(b.y == Approx(2 * sum).epsilon(1e-12));
                    REQUIRE(b.z == 0);
                }
                CHECK(x.residual == Approx(power / sum).epsilon(1e-9).margin(1e-150));
            }
            for (Solver solver : all_solvers) {
                if (solver == Solver::passes && rho > 0.99f) continue;       // 14 million
                if (solver == Solver::shooting && rho > 0.99f) continue;     // as many
                if (solver == Solver::gauss_seidel && rho > 0.99f) continue;  // half as many
                CAPTURE(solver_name(solver));
                const Solution x = solved(s, solver, 1e-7, 100000, rounding);
                CHECK(x.converged);
                CHECK(x.radius.high >= r * (1 - 1e-12));
                for (const glm::dvec3& b : x.radiosity) {
                    REQUIRE(b.x == Approx(1 / (1 - r)).epsilon(2e-7));
                    REQUIRE(b.y == Approx(2 / (1 - r)).epsilon(2e-7));
                    REQUIRE(b.z == 0);
                }
            }
        }
}

TEST_CASE("radiosity: inside of a sphere B = E + rho / (1 - rho) mean(E)", "[radiosity][analytic]") {
    DenseSystem s = sphere(12, 0.75f);
    glm::dvec3 mean(0);
    std::vector<glm::dvec3> e;
    for (int i = 0; i < s.n; ++i) {
        s.exitance[i] = i == 7 ? glm::vec4(3, 0, 1e-6f, 0) : glm::vec4(0, 0, 0, 0);
        s.incident[i] = glm::vec4(0, float(i) * 1e6f, 0.25f, 0);
        e.push_back(glm::dvec3(s.exitance[i]) + 0.75 * glm::dvec3(s.incident[i]));
        mean += s.area[i] * e[i];
    }
    for (Solver solver : all_solvers) {
        CAPTURE(solver_name(solver));
        const Solution x = solved(s, solver, 1e-10);
        CHECK(off(x.radiosity, [&](int i, int c) { return e[i][c] + 3 * mean[c]; }) <= 1e-8);
    }
}

TEST_CASE("radiosity: concentric spheres are 10/9 and 2/9", "[radiosity][analytic]") {
    DenseSystem s(2);
    s.at(0, 1) = 1, s.at(1, 0) = 0.25, s.at(1, 1) = 0.75;
    s.area = {1, 4};
    s.reflect(0.5f);
    s.exitance[0] = glm::vec4(1, 1, 1, 0);
    for (Solver solver : all_solvers)
        for (Rounding rounding : {Rounding::none, Rounding::floats, Rounding::floats_about_mean}) {
            CAPTURE(solver_name(solver), int(rounding));
            const Solution x = solved(s, solver, 1e-6, 1000, rounding);
            CHECK(x.converged);
            CHECK(off(x.radiosity, [](int i, int) { return i == 0 ? 10.0 / 9 : 2.0 / 9; }) <= 1e-5);
        }
}

TEST_CASE("radiosity: six reflectances in three channels against Eigen's LU", "[radiosity]") {
    DenseSystem s = cube_of_six(0);
    const float rho[] = {0.1f, 0.9f, 0, 1, 0.5f, 0.999f};
    for (int i = 0; i < 6; ++i) {
        s.reflectance[i] = glm::vec4(rho[i], rho[(i + 2) % 6], rho[5 - i], 0);
        s.exitance[i] = glm::vec4(i == 1, 1e-4f * float(i + 1), i % 2, 0);
        s.incident[i] = glm::vec4(0.1f * float(i), 1, 0, 0);
    }
    const std::vector<glm::dvec3> truth = truth_of(s, rows_of(s, false)), rounded = truth_of(s, rows_of(s, true));
    for (Solver solver : all_solvers) {
        CAPTURE(solver_name(solver));
        const bool rows = solver != Solver::passes && solver != Solver::bicgstab;
        // Float rows are reciprocal here, so those that average or turn rows solve the same system.
        CHECK(off(solved(s, solver, 1e-12).radiosity, rows ? rounded : truth) <= 1e-9);
    }
}

TEST_CASE("radiosity: manufactured solutions on random rows", "[radiosity]") {
    const int n = 2000;
    DenseSystem s(n);
    std::vector<glm::dvec3> b;
    for (int i = 0; i < n; ++i) {
        const auto near_one = [&](int k) { return 1 + 0.25 * hashed_share(i, k, 7); };
        b.emplace_back(near_one(0), 1e6 * near_one(1), 1e-6 * near_one(2));
        s.area[i] = 1e-3 + hashed_share(i, 3, 7);
        // At most: 0.8 times 1.25 is 1, so that no element must emit less than nothing.
        s.reflectance[i] = glm::vec4(float(0.79 * hashed_share(i, 4, 7)), float(0.79 * hashed_share(i, 5, 7)), 0.79f, 0);
    }
    // A_i F_ij = G_ij + little: G symmetric.
    for (int i = 0; i < n; ++i) {
        double sum = 0;
        for (int j = 0; j < n; ++j) sum += s.at(i, j) = j == i ? 0 : hashed_share(i, j, 11);
        const double row = 0.3 + 0.69 * hashed_share(i, 6, 7);
        for (int j = 0; j < n; ++j) s.at(i, j) = double(float(s.at(i, j) * row / sum));
    }
    std::vector<glm::dvec3> left(b.size());
    for (int i = 0; i < n; ++i) {
        glm::dvec3 h(0);
        for (int j = 0; j < n; ++j) h += s.at(i, j) * b[j];
        const glm::dvec3 m = b[i] - glm::dvec3(s.reflectance[i]) * h;
        REQUIRE(std::min(m.x, std::min(m.y, m.z)) >= 0);
        s.exitance[i] = glm::vec4(glm::vec3(m), 0);
    }
    // Emission in floats is 6e-8 off, which the rest multiplies by 1 / (1 - 0.79) at most.
    for (Solver solver : {Solver::passes, Solver::gauss_seidel, Solver::bicgstab}) {
        CAPTURE(solver_name(solver));
        const Solution x = solved(s, solver, 1e-8);
        CHECK(x.converged);
        CHECK(off(x.radiosity, b) <= 3.5e-7);
        CHECK(x.row_residual <= 1e-8);
    }
    // Rows that are not reciprocal: what turns them round or averages them solves another system, and says so.
    for (Solver solver : {Solver::shooting, Solver::conjugate_gradients}) {
        CAPTURE(solver_name(solver));
        const Solution x = solved(s, solver, 1e-5);
        CHECK(x.error <= 1e-5);
        CHECK(x.row_residual > 1e-3);
    }
}

TEST_CASE("radiosity: averaged rows keep a closed room's energy", "[radiosity][analytic]") {
    // Rows that sum to one and are far from reciprocal: light is even where all emits and reflects alike, whatever they are, and what is
    // emitted is absorbed.
    const int n = 40;
    for (const float rho : {0.5f, 0.99f, 0.999999f}) {
        DenseSystem s(n);
        for (int i = 0; i < n; ++i) {
            s.area[i] = 0.1 + hashed_share(i, 1, 3);
            double sum = 0;
            for (int j = 0; j < n; ++j) sum += s.at(i, j) = hashed_share(i, j, 5);
            for (int j = 0; j < n; ++j) s.at(i, j) /= sum;
        }
        s.reflect(rho);
        s.exitance.assign(std::size_t(n), glm::vec4(1, 0, 0, 0));
        s.exitance[7].y = 1;
        const Transport t = s.transport(Rounding::floats_about_mean);
        SolveParams params;
        params.solver = Solver::conjugate_gradients, params.tolerance = 1e-6;
        const Solution x = solve(s.system(), t, params);
        CAPTURE(rho, x.why);
        CHECK(x.converged);
        double power = 0;
        for (int i = 0; i < n; ++i) {
            CHECK(x.radiosity[i].x * (1 - double(rho)) == Approx(1).epsilon(2e-6));
            power += s.area[i] * x.radiosity[i].y * (1 - double(rho));
        }
        CHECK(power == Approx(s.area[7]).epsilon(1e-5));
    }
}

TEST_CASE("radiosity: fine meshes come to the continuous solution, not to the table", "[radiosity][analytic]") {
    DenseSystem s = cube_of_patches(10, 0.5f);
    s.transport();
    for (double sum : s.sums) REQUIRE(sum == Approx(1).epsilon(1e-12));
    DenseSystem coarse = cube_of_patches(5, 0.5f);
    double emitter = 0;
    for (int i = 0; i < 25; ++i) emitter += solved(coarse, Solver::bicgstab, 1e-7).radiosity[i].x / 25;
    CHECK(std::fabs(emitter - 1.1044) > 1.5 * 7e-4);  // twice as coarse, at least half as far off again
    for (Solver solver : {Solver::passes, Solver::bicgstab, Solver::conjugate_gradients, Solver::shooting}) {
        CAPTURE(solver_name(solver));
        const Solution x = solved(s, solver, 1e-7);
        CHECK(x.converged);
        double face[6] = {};
        for (int i = 0; i < s.n; ++i) face[i / 100] += x.radiosity[i].x / 100;
        CHECK(face[0] == Approx(1.1044).margin(8e-4));  // a table's element would be at 1.0909
        CHECK(face[1] == Approx(0.1712).margin(4e-4));
        for (int k = 2; k < 6; ++k) CHECK(face[k] == Approx(0.1811).margin(4e-4));
    }
}

TEST_CASE("radiosity: progressive refinement and its ambient term", "[radiosity][analytic]") {
    // Inside of a sphere all light that is unshot spreads evenly: with ambient the first picture is the last one.
    DenseSystem s = sphere(8, 0.5f);
    s.exitance[0] = glm::vec4(1, 1, 1, 0);
    SolveParams params;
    params.solver = Solver::shooting, params.tolerance = 0.9;
    const Transport t = s.transport();
    const Solution x = solve(s.system(), t, params);
    CHECK(x.products <= 1);
    CHECK(x.ambient.x > 0);
    const Buffer<glm::vec4> b = shown(x, s.system());
    for (int i = 1; i < s.n; ++i) CHECK(b[i].x == Approx(0.5).epsilon(1e-6));  // rho / (1 - rho) / 2
    CHECK(b[0].x == Approx(1.5).epsilon(1e-6));

    params.tolerance = 1e-6;
    const Solution y = solve(s.system(), t, params);
    CHECK(y.unshot <= 1e-6);
    CHECK(y.unshot > 0);
    for (std::size_t k = 1; k < y.curve.size(); ++k) CHECK(y.curve[k].power > y.curve[k - 1].power);
}

TEST_CASE("radiosity: energy is emitted, absorbed or gone, to rounding", "[radiosity][analytic]") {
    DenseSystem s = cube_of_patches(4, 0.8f);
    const double corner = s.at(0, 40);
    for (int j = 0; j < s.n; ++j) s.at(5, j) *= 0.5;   // half of what this one sees is open sky
    s.incident[3] = glm::vec4(0, 2, 4, 0);
    const Solution x = solved(s, Solver::bicgstab, 1e-12);
    const Transport t = s.transport();
    const Audit a = audit(s.system(), t, x.radiosity, s.n);
    CHECK(a.emitted == Approx(3).epsilon(1e-6));  // one face of 1 m2, 1 W/m2 a channel
    CHECK(a.incident == Approx(6.0 / 16).epsilon(1e-12));
    CHECK(a.escaped > 0);
    CHECK(std::fabs(a.unbalanced) <= 1e-13);
    CHECK(std::fabs(a.unsolved) <= 1e-6);  // rows in floats against gather in double
    CHECK(a.emitted + a.incident == Approx(a.absorbed + a.escaped + a.not_reciprocal).epsilon(1e-6));
    CHECK(a.least_row == Approx(0.5).epsilon(1e-6));
    CHECK(a.largest_row == Approx(1).epsilon(1e-6));
    CHECK(a.mean_row == Approx(1 - 0.5 / s.n).epsilon(1e-6));
    CHECK(a.all_pairs);
    CHECK(a.pairs == std::int64_t(s.n) * (s.n - 1) / 2);
    CHECK(a.defect_worst > 0);
    CHECK(a.gather_off <= 1e-7);
    CHECK(corner > 0);

    // Any radiosities at all: the residual is in the balance.
    const std::vector<glm::dvec3> wrong(std::size_t(s.n), glm::dvec3(1, 2, 3));
    const Audit w = audit(s.system(), t, wrong, 7);
    CHECK(std::fabs(w.unsolved) > 1);
    CHECK(std::fabs(w.unbalanced) <= 1e-12);
    CHECK(w.pairs == 21);
    CHECK_FALSE(w.all_pairs);

    // A sphere loses nothing and is reciprocal; a gather that gives nothing is seen.
    DenseSystem r = sphere(8, 0.5f);
    r.exitance[2] = glm::vec4(1, 0, 0, 0);
    Transport q = r.transport();
    const Audit b = audit(r.system(), q, solved(r, Solver::direct, 1e-12).radiosity);
    CHECK(std::fabs(b.absorbed - b.emitted) <= 1e-12);
    CHECK(b.defect_worst == 0);
    CHECK(std::fabs(b.escaped) <= 1e-15);
    q.gather_double = [](const auto&, Buffer<glm::dvec4>& h, const RunOptions&) { h.assign(h.size(), glm::dvec4(0)); };
    CHECK(audit(r.system(), q, solved(r, Solver::direct).radiosity).gather_off == 1);
}
