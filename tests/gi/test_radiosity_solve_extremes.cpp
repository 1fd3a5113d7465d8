// Radiosity solvers near reflectances of one, with what is not allowed, and the table of their iterations.
#include <catch2/catch.hpp>
#include <fmt/format.h>

#include "core/content_hasher.h"
#include "core/error.h"
#include "gi/radiosity/solve.h"
#include "gi/radiosity/solve_choose.h"
#include "tests/gi/radiosity_systems.h"

using namespace plumb;
using namespace plumb::radiosity;
using Catch::Matchers::Contains;

namespace {

std::string refusal(DenseSystem& s, Solver solver = Solver::bicgstab) {
    try {
        solved(s, solver);
    } catch (const InputError& e) {
        return e.what();
    }
    return "";
}

// A cube in patches, made once; rows do not depend on what is emitted and reflected.
DenseSystem patches(float rho) {
    static const DenseSystem cube = cube_of_patches(8, 0.5f);
    DenseSystem s = cube;
    s.reflect(rho);
    return s;
}

}  // namespace

// ---- What each solver takes -----------------------------------------------------------------------------------------

namespace {

// Products with all rows until the estimated relative error is 1e-6; those of the radius are among them.
struct Took {
    double products;
    bool converged;
};
Took took(Solver solver, float rho, int most) {
    DenseSystem s = patches(rho);
    const Solution x = solved(s, solver, 1e-6, most);
    return {x.products, x.converged};
}

}  // namespace

TEST_CASE("radiosity: products that each solver takes", "[radiosity]") {
    // Passes: ln(1e-6 c) / ln(rho), c from 1 / 3 to 1 as the emitter's share of the norm.
    for (float rho : {0.5f, 0.9f, 0.99f}) {
        CAPTURE(rho);
        const Took p = took(Solver::passes, rho, 2000);
        CHECK(p.converged);
        CHECK(p.products <= passes_expected(double(rho), 1e-6) + 1);
        CHECK(p.products >= passes_expected(double(rho), 3e-6));
        // What is used as soon as it is known counts twice.
        const Took g = took(Solver::gauss_seidel, rho, 2000);
        CHECK(g.converged);
        CHECK(g.products <= 0.62 * p.products + 8);
    }
    for (float rho : {0.5f, 0.9f, 0.99f, 0.999f, 0.999999f}) {
        CAPTURE(rho);
        for (Solver solver : {Solver::bicgstab, Solver::conjugate_gradients, Solver::direct}) {
            CAPTURE(solver_name(solver));
            const Took t = took(solver, rho, 200);
            // LU solves for rows in floats, its residual is from rows in doubles.
            CHECK((t.converged || solver == Solver::direct));
            CHECK(t.products <= 40);
        }
        CHECK(took(Solver::bicgstab, rho, 200).products <= krylov_products_expected(double(rho), 1e-6) + 12);
    }
}

TEST_CASE("radiosity: the table of README.md", "[.][radiosity_table]") {
    std::string table = "| rho | passes | shooting | Gauss and Seidel | BiCGSTAB | conjugate gradients |\n|---|---|---|---|---|---|\n";
    for (float rho : {0.5f, 0.9f, 0.99f, 0.999f, 0.999999f}) {
        table += fmt::format("| {:g} ", rho);
        for (Solver solver : {Solver::passes, Solver::shooting, Solver::gauss_seidel, Solver::bicgstab, Solver::conjugate_gradients}) {
            const bool slow = rho > 0.9995f && int(solver) < int(Solver::bicgstab);
            if (slow) {
                table += "| - ";
                continue;
            }
            const Took t = took(solver, rho, 20000);
            table += fmt::format("| {:.4g}{} ", t.products, t.converged ? "" : " (not converged)");
        }
        table += "|\n";
    }
    WARN(table);
    CHECK(table.find("not converged") == std::string::npos);
}

TEST_CASE("radiosity: solvers that are limited by rounding say so", "[radiosity][analytic]") {
    // Gathered in floats, 6e-8 of the irradiance is lost a product: 6 % of the solution at 0.999999.
    DenseSystem s = patches(0.999999f);
    const Solution rounded = solved(s, Solver::bicgstab, 1e-6, 200, Rounding::floats);
    CHECK_FALSE(rounded.converged);
    CHECK(rounded.error > 1e-6);
    CHECK_THAT(rounded.why, Contains("rounded"));
    // What is lost in one pass is in all after it: the last steps are small and say nothing of that.
    DenseSystem cube = cube_of_six(0.99f);
    const Solution passes = solved(cube, Solver::passes, 1e-8, 5000, Rounding::floats);
    CHECK_FALSE(passes.converged);
    CHECK_THAT(passes.why, Contains("rounded"));
    CHECK(passes.error == Approx(0x1p-24 / (1 - double(0.99f))).epsilon(0.2));  // 2^-24 of all that is gathered
    CHECK(passes.error >= std::fabs(passes.radiosity[0].x / cube_radiosity(double(0.99f))[0] - 1));
    // Without the mean almost nothing is left to be rounded. Mean of a closed scene: the mean of M over 1 - rho.
    const Solution about = solved(s, Solver::bicgstab, 1e-6, 200, Rounding::floats_about_mean);
    CHECK(about.converged);
    double mean = 0;
    for (const glm::dvec3& b : about.radiosity) mean += b.x / s.n;
    CHECK(mean * 6 * (1 - double(0.999999f)) == Approx(1).epsilon(0.01));  // rows are not quite reciprocal
}

TEST_CASE("radiosity: the same bits for any number of threads, and everywhere", "[radiosity]") {
    DenseSystem s = patches(0.9f);
    for (int i = 0; i < s.n; ++i) s.reflectance[i].y = float(i) / float(s.n), s.incident[i].z = float(i % 7);
    // What this test case prints where they differ; the same of gcc and clang, optimised and not.
    const std::uint64_t expected[] = {0xb26aae1ae84572d2, 0xeabbe064ed1fbdbb, 0x424aca88d5011531,
                                      0xb57264f123ae0e6c, 0xfc3dcc232d2487d8, 0xd8a12e88639f9c64};
    for (Solver solver : all_solvers) {
        CAPTURE(solver_name(solver));
        std::uint64_t first = 0;
        for (int threads : {1, 2, 3, 7})
            for (Isa isa : supported_isas()) {
                RunOptions options;
                options.threads = threads, options.isa = isa;
                const Solution x = solved(s, solver, 1e-5, 1000, Rounding::none, options);
                ContentHasher hasher;
                hasher.add_all(x.radiosity);
                hasher.add(x.residual, x.error, x.products);
                if (!first) first = hasher.hash;
                REQUIRE(hasher.hash == first);
                if (threads > 1) break;
            }
        CHECK(first == expected[int(solver)]);
    }
}

// ---- What there is to refuse ----------------------------------------------------------------------------------------

TEST_CASE("radiosity: reflectances of one where no light is lost name an element", "[radiosity]") {
    DenseSystem s = patches(1);
    for (Solver solver : all_solvers) CHECK_THAT(refusal(s, solver), Contains("element 0: reflects all light"));
    s.reflectance[200] = glm::vec4(0.5f, 0.5f, 1, 0);
    CHECK_THAT(refusal(s), Contains("element 0"));  // blue has no end yet
    s.reflectance[200].z = 0.5f;
    for (Solver solver : {Solver::bicgstab, Solver::conjugate_gradients, Solver::direct}) {
        const Solution x = solved(s, solver, 1e-5, 1000);
        CHECK(x.error <= 1e-4);
        // All that is emitted, 1 W, ends in the one element: (1 - rho) A H; rows are not quite reciprocal.
        CHECK((1 - 0.5) / 0.5 * x.radiosity[200].x / 64 == Approx(1).epsilon(0.2));
    }

    // Two rooms, one of them without loss and without light: it has no solution either, and it is the one that is named.
    DenseSystem two(4);
    two.at(0, 1) = two.at(1, 0) = 1, two.at(2, 3) = two.at(3, 2) = 1;
    two.reflectance = {glm::vec4(0.5f), glm::vec4(0.5f), glm::vec4(1), glm::vec4(1)};
    two.exitance[0] = glm::vec4(1);
    CHECK_THAT(refusal(two), Contains("element 2"));
    // A given number of passes ends.
    CHECK(solved(two, Solver::passes, 0, 5).curve.size() == 5);

    // Rows that sum to more than one grow light at reflectances below one: texels' weights at centres are 1.3e-4 too much.
    DenseSystem grows = sphere(8, 0.99995f);
    for (double& f : grows.f) f *= 1.00013;
    grows.exitance[0] = glm::vec4(1);
    CHECK_THAT(refusal(grows), Contains("element 0"));
    DenseSystem fast(2);
    fast.at(0, 1) = 3, fast.at(1, 0) = 0.9;
    fast.reflect(0.9f);
    fast.exitance[0] = glm::vec4(1);
    for (Solver solver : {Solver::bicgstab, Solver::direct, Solver::gauss_seidel})
        CHECK_THAT(refusal(fast, solver), Contains("light grows"));
    CHECK_THAT(solved(fast, Solver::passes, 0, 2000).why, Contains("light grows"));
}

TEST_CASE("radiosity: two rooms, an element that sees nothing, one that sees itself", "[radiosity][analytic]") {
    // Two parallel pairs far from each other, and a black one: B1 = E1 + rho B2, B2 = rho B1.
    DenseSystem s(6);
    s.at(0, 1) = s.at(1, 0) = 1, s.at(2, 3) = s.at(3, 2) = 1;
    s.at(5, 5) = 0.5;  // a bowl: B = M + rho / 2 B
    s.reflect(0.5f);
    s.exitance[0] = glm::vec4(3, 0, 0, 0), s.exitance[3] = glm::vec4(0, 3, 0, 0);
    s.exitance[4] = glm::vec4(1, 1, 1, 0), s.exitance[5] = glm::vec4(3, 0, 0, 0);
    const double truth[6][2] = {{4, 0}, {2, 0}, {0, 2}, {0, 4}, {1, 1}, {4, 0}};
    for (Solver solver : all_solvers) {
        CAPTURE(solver_name(solver));
        const Solution x = solved(s, solver, 1e-9);
        CHECK(x.converged);
        for (int i = 0; i < 6; ++i) {
            CHECK(x.radiosity[i].x == Approx(truth[i][0]).margin(1e-8));
            CHECK(x.radiosity[i].y == Approx(truth[i][1]).margin(1e-8));
            CHECK(x.radiosity[i].z == Approx(i == 4 ? 1 : 0).margin(1e-12));
        }
    }
    const Transport t = s.transport();
    const Radius r = spectral_radius(s.system(), t);
    CHECK(r.settled);
    CHECK(r.high == Approx(0.5).epsilon(1e-12));
    CHECK(1 / (1 - r.value) == Approx(2).epsilon(0.1));  // what settled says
}

TEST_CASE("radiosity: the radius says when it has not settled", "[radiosity][analytic]") {
    DenseSystem s = patches(0.999f);
    const Transport t = s.transport();
    CHECK_FALSE(spectral_radius(s.system(), t, 1).settled);
    const Radius r = spectral_radius(s.system(), t);
    CHECK(r.settled);
    CHECK(std::fabs(r.value - double(0.999f)) <= 1e-6);  // closed: the vector of ones is the slow one
    // One bright element among dark ones: its reflectance says little.
    s.reflect(0.25f);
    s.reflectance[0] = glm::vec4(0.999f);
    const Radius q = spectral_radius(s.system(), t);
    CHECK(q.settled);
    CHECK(q.high < 0.35);
    CHECK(q.low <= q.value);
    CHECK(q.value <= q.high);
    // To and fro between two mirrors of different reflectance: ratios of single steps never settle; the radius is the root.
    DenseSystem two(2);
    two.at(0, 1) = two.at(1, 0) = 1;
    two.reflectance = {glm::vec4(0.25f), glm::vec4(1)};
    const Transport u = two.transport();
    CHECK(spectral_radius(two.system(), u).value == Approx(0.5).epsilon(1e-12));
    CHECK(spectral_radius(two.system(), u).high == Approx(0.5).epsilon(1e-12));
}

TEST_CASE("radiosity: while light has not come everywhere passes do not take their radius for settled", "[radiosity]") {
    // A corridor: each element sees its two neighbours, the last ones themselves; light enters at one end.
    const int n = 40;
    DenseSystem s(n);
    for (int i = 0; i < n; ++i) s.at(i, std::max(i - 1, 0)) += 0.5, s.at(i, std::min(i + 1, n - 1)) += 0.5;
    s.reflect(0.95f);
    s.exitance[0] = glm::vec4(1, 1, 1, 0);
    const std::vector<glm::dvec3> truth = solved(s, Solver::direct, 1e-10).radiosity;
    for (int k : {3, 5, 10, 20, 39, 80, 160}) {
        CAPTURE(k);
        const Solution x = solved(s, Solver::passes, 0, k);
        double error = 0, all = 0;
        for (int i = 0; i < n; ++i) {
            const double d = x.radiosity[i].x - truth[i].x;
            error += d * d, all += x.radiosity[i].x * x.radiosity[i].x;
        }
        CHECK(x.error >= std::sqrt(error / all));
        if (k < n) CHECK_FALSE(x.radius.settled);
        if (k < n) CHECK(x.radius.high == double(0.95f));  // the reflectance stands for it
    }
}

TEST_CASE("radiosity: no light, no elements, one element, no area", "[radiosity][analytic]") {
    for (Solver solver : all_solvers) {
        CAPTURE(solver_name(solver));
        DenseSystem none(0);
        CHECK(solved(none, solver).converged);
        CHECK(solved(none, solver).radiosity.empty());
        DenseSystem dark = patches(0.9f);
        dark.exitance.assign(dark.n, glm::vec4(0));
        const Solution d = solved(dark, solver);
        CHECK(d.converged);
        for (const glm::dvec3& b : d.radiosity) REQUIRE(b == glm::dvec3(0));
        DenseSystem one(1);
        one.at(0, 0) = 0.75;
        one.reflect(0.5f);
        one.exitance[0] = glm::vec4(5, 10, 0, 0);
        const Solution x = solved(one, solver, 1e-12);
        CHECK(x.radiosity[0].x == Approx(8).epsilon(1e-10));  // 5 / (1 - 0.375)
        CHECK(x.radiosity[0].y == Approx(16).epsilon(1e-10));
        // An element without area, and slivers of a millionth: they see what the others send.
        DenseSystem s = cube_of_six(0.5f);
        s.area = {1e6, 1e6, 1e6, 1e6, 1e6, 0};
        for (int i = 0; i < 5; ++i) s.at(i, 5) = 0;
        const Solution y = solved(s, solver, 1e-10);
        double h = 0;
        for (int j = 0; j < 5; ++j) h += s.at(5, j) * y.radiosity[j].x;
        CHECK(y.radiosity[5].x == Approx(0.5 * h).epsilon(1e-6));
    }
    // Areas of a million to one do not matter to rows.
    DenseSystem s = patches(0.9f);
    const std::vector<glm::dvec3> truth = solved(s, Solver::passes, 1e-10).radiosity;
    for (int i = 0; i < s.n; ++i) s.area[i] = i % 3 ? 1e3 : 1e-3;
    const Solution x = solved(s, Solver::bicgstab, 1e-10);
    CHECK(x.converged);
    for (int i = 0; i < s.n; ++i) REQUIRE(x.radiosity[i].x == Approx(truth[i].x).epsilon(1e-5));
}

TEST_CASE("radiosity: what is no system is refused", "[radiosity]") {
    const float bad[] = {NAN, INFINITY, -INFINITY, -1e-6f};
    for (float v : bad) {
        CAPTURE(v);
        DenseSystem s = patches(0.5f);
        s.exitance[3].y = v;
        CHECK_THAT(refusal(s), Contains("exitance: element 3"));
        s = patches(0.5f), s.incident[4].z = v;
        CHECK_THAT(refusal(s), Contains("incident irradiance: element 4"));
        s = patches(0.5f), s.reflectance[5].x = v;
        CHECK_THAT(refusal(s), Contains("reflectance: element 5"));
        s = patches(0.5f), s.area[6] = double(v);
        CHECK_THAT(refusal(s), Contains("area: element 6"));
        s = patches(0.5f), s.at(7, 8) = double(v);
        CHECK_THAT(refusal(s, Solver::gauss_seidel), Contains("7"));  // the row, or what it gathers
        CHECK_THAT(refusal(s, Solver::shooting), Contains("row 7: number 8"));
    }
    DenseSystem s = patches(0.5f);
    s.reflectance[2].x = 1.0000001f;
    CHECK_THAT(refusal(s), Contains("element 2 is 1: expected 0 to 1"));
    s = patches(0.5f);
    s.exitance.pop_back();
    CHECK_THAT(refusal(s), Contains("383 elements: 384 expected"));

    s = patches(0.5f);
    const Transport t = s.transport();
    SolveParams params;
    params.solver = Solver::direct, params.most_bytes = 1000000;
    CHECK_THROWS_WITH(solve(s.system(), t, params), Contains("384 elements need 0.00118 GB") && Contains("353 elements"));
    params.tolerance = -1;
    CHECK_THROWS_WITH(solve(s.system(), t, params), Contains("tolerance"));
    params = {}, params.most_products = 0;
    CHECK_THROWS_WITH(solve(s.system(), t, params), Contains("most_products"));
    CHECK_THROWS_WITH(parse_solver("jacobi"), Contains("passes, shooting, gauss_seidel, bicgstab"));
    for (Solver solver : all_solvers) CHECK(parse_solver(solver_name(solver)) == solver);
    Transport empty = t;
    empty.gather = nullptr;
    CHECK_THROWS_AS(solve(s.system(), empty, {}), InputError);
}

// ---- Passes as they are kept, and the choice ------------------------------------------------------------------------

TEST_CASE("radiosity: passes keep what the caller makes of them", "[radiosity][HEM 4.5.4][analytic]") {
    // Saturated at 1, as colours are: the emitter is 1 from the first pass on, the others what they gather of that.
    DenseSystem s = sphere(4, 0.5f);
    s.exitance[0] = glm::vec4(4, 4, 4, 0);
    SolveParams params;
    params.solver = Solver::passes, params.tolerance = 0, params.most_products = 40;
    int calls = 0;
    params.store = [&](Buffer<glm::vec4>& b) {
        for (glm::vec4& v : b) v = glm::min(v, glm::vec4(1));
        ++calls;
    };
    const Transport t = s.transport();
    const Solution x = solve(s.system(), t, params);
    CHECK(calls == 40);
    CHECK(x.radiosity[0].x == 1);
    // A_0 is half the sphere: B = (0.5 + 0.5 B) / 2.
    for (int i = 1; i < 4; ++i) CHECK(x.radiosity[i].x == Approx(1.0 / 3).epsilon(1e-6));
    CHECK_FALSE(x.converged);
    CHECK(x.residual > 1);  // of the system without saturation
    params.solver = Solver::bicgstab;
    CHECK_THROWS_WITH(solve(s.system(), t, params), Contains("need the solver passes"));
}

TEST_CASE("radiosity: a solver is recommended with its reason", "[radiosity]") {
    TransportFacts f;
    f.count = 15814, f.row_bytes = 500'000'000, f.largest_reflectance = 0.5;
    CHECK(recommend(f).solver == Solver::passes);
    CHECK(recommend(f).products == 14);  // ln 1e-4 / ln 0.5 = 13.3
    CHECK(recommend(f).seconds == Approx(14 * 0.25));
    CHECK_THAT(recommend(f).reason, Contains("radius 0.5") && Contains("14 products"));
    f.largest_reflectance = 0.99;
    CHECK(recommend(f).solver == Solver::bicgstab);
    CHECK_THAT(recommend(f).reason, Contains("passes would take 917 products"));
    f.largest_reflectance = 1;
    CHECK(recommend(f).solver == Solver::bicgstab);
    f.radius = {0.4, 0.45, 0.3, 7, true};  // few are that bright
    CHECK(recommend(f).solver == Solver::passes);
    f.radius = {1.01, 1.02, 1.005, 7, false};
    CHECK_THROWS_WITH(recommend(f), Contains("without end"));
    f.radius = {}, f.largest_reflectance = 0.999999, f.count = 6;
    CHECK(recommend(f).solver == Solver::direct);
    f.count = 0;
    CHECK_THAT(recommend(f).reason, Contains("no elements"));
    f.largest_reflectance = 1.5;
    CHECK_THROWS_AS(recommend(f), InputError);
    f.largest_reflectance = NAN;
    CHECK_THROWS_AS(recommend(f), InputError);

    DenseSystem s = patches(0.9f);
    const Transport t = s.transport();
    const TransportFacts facts = facts_of(s.system(), t);
    CHECK(facts.count == 384);
    CHECK(facts.largest_reflectance == double(0.9f));
    CHECK(facts.radius.value == Approx(0.9).epsilon(1e-3));
    CHECK(facts.seconds_per_product > 0);
    s.reflect(1);
    CHECK_THROWS_WITH(facts_of(s.system(), t), Contains("element 0"));
}
