#include "gi/radiosity/solve_choose.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/error.h"
#include "core/fp_environment.h"
#include "core/host_math.h"
#include "gi/radiosity/solve_problem.h"

namespace plumb::radiosity {

namespace {

// A product reads all rows once; two cores of 2020 read and add so many bytes of compressed rows a second.
constexpr double bytes_per_second = 2e9;
// A product's work for one element, in multiplications of LU's inner loop.
constexpr double work_per_entry = 6;

std::string time_text(double seconds) { return seconds > 0 ? fmt::format(", {:.2g} s", seconds) : ""; }

}  // namespace

double passes_expected(double radius, double tolerance) {
    if (!(radius > 0)) return 1;
    if (!(radius < 1)) return HUGE_VAL;
    return std::max(1.0, std::ceil(host::log(tolerance) / host::log(radius)));
}

// Krylov methods see few eigenvalues far from the others, each of which costs an iteration, and then converge as if those
// were not there: in the table of README.md an iteration gains a factor of about 4, and 6 more are needed at the end
// of the scale. The bound of conjugate gradients, 0.5 sqrt(condition) ln(2 / tolerance), is lower where little is reflected.
double krylov_products_expected(double radius, double tolerance) {
    if (!(radius < 1)) return HUGE_VAL;
    const double needed = host::log(1 / (tolerance * (1 - radius)));
    const double bound = 0.5 * std::sqrt((1 + radius) / (1 - radius)) * host::log(2 / tolerance);
    return 2 * std::ceil(std::max(1.0, std::min(bound, needed / host::log(4.0) + 1)));
}

Recommendation recommend(const TransportFacts& f) {
    if (!(f.largest_reflectance >= 0 && f.largest_reflectance <= 1))
        throw InputError(fmt::format("radiosity: a reflectance of {:g}: expected 0 to 1", f.largest_reflectance));
    if (!(f.tolerance > 0 && f.tolerance < 1))
        throw InputError(fmt::format("radiosity: tolerance = {:g}: expected more than 0, less than 1", f.tolerance));
    if (f.radius.products && f.radius.low >= 1)
        throw InputError(fmt::format("radiosity: each reflection returns {:.9g} times what came: light grows without end",
                                     f.radius.low));
    Recommendation out;
    const bool estimated = f.radius.products > 0;
    const double radius = estimated ? std::min(f.radius.high, 1.0) : f.largest_reflectance;
    const double each = f.seconds_per_product > 0 ? f.seconds_per_product : f.row_bytes / bytes_per_second;
    const std::string of = fmt::format("radius {:.6g} {}", radius, estimated ? f.radius.settled ? "" : "at most, not settled"
                                                                             : "at most, by the reflectance");
    const double passes = passes_expected(radius, f.tolerance), krylov = krylov_products_expected(radius, f.tolerance);
    const double n = f.count, direct = 2.0 / (3 * work_per_entry) * n;  // an LU in products

    if (f.count == 0) return out.reason = "there are no elements", out;
    if (std::isfinite(passes) && passes <= krylov) {
        out.solver = Solver::passes, out.products = passes;
        out.seconds = passes * each;
        out.reason = fmt::format("{}: {} gives {:g} in {:g} products with all rows{}, bicgstab in about {:g}", of, "passes",
                                 f.tolerance, passes, time_text(out.seconds), krylov);
    } else if (3 * direct <= krylov && direct_bytes(f.count) <= f.most_bytes) {
        out.solver = Solver::direct, out.products = 3 * direct;
        out.seconds = out.products * each;
        out.reason = fmt::format("{}: passes would take {:g} products, and the matrix of {} elements is only {:.3g} MB", of,
                                 passes, f.count, 1e-6 * direct_bytes(f.count));
    } else {
        out.solver = Solver::bicgstab, out.products = krylov;
        out.seconds = std::isfinite(krylov) ? krylov * each : 0;
        out.reason = fmt::format("{}: passes would take {:g} products with all rows for {:g}, bicgstab about {:g}{}", of,
                                 passes, f.tolerance, krylov, time_text(out.seconds));
    }
    return out;
}

TransportFacts facts_of(const System& system, const Transport& transport, const RunOptions& options) {
    FpEnvironment environment;
    Problem problem(system, transport, options);
    TransportFacts f;
    f.count = problem.count;
    for (const glm::dvec3& rho : problem.reflectance)
        f.largest_reflectance = std::max(f.largest_reflectance, std::max(rho.x, std::max(rho.y, rho.z)));
    if (const int element = element_without_loss(problem); element >= 0)
        throw InputError(fmt::format("radiosity: element {}: reflects all light and sees only elements that do: expected a "
                                     "reflectance below 1, or a way out", element));
    const auto start = std::chrono::steady_clock::now();
    f.radius = power_iteration(problem, 64);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (f.radius.products) f.seconds_per_product = seconds / f.radius.products;
    return f;
}

}  // namespace plumb::radiosity
