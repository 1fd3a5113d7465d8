#include "gi/radiosity/solve.h"

#include <fmt/format.h>

#include <cmath>

#include "core/error.h"
#include "core/fp_environment.h"
#include "gi/radiosity/solve_problem.h"

namespace plumb::radiosity {

namespace {

constexpr const char* names[] = {"passes", "shooting", "gauss_seidel", "bicgstab", "conjugate_gradients", "direct"};

void check(const SolveParams& params) {
    if (!(params.tolerance >= 0 && params.tolerance < 1))
        throw InputError(fmt::format("radiosity: tolerance = {:g}: expected 0 to 1", params.tolerance));
    if (params.most_products < 1)
        throw InputError(fmt::format("radiosity: most_products = {}: expected 1 or more", params.most_products));
    if (params.store && params.solver != Solver::passes)
        throw InputError("radiosity: radiosities that are stored between passes need the solver passes");
}

Solution run(Problem& problem, const SolveParams& params) {
    switch (params.solver) {
        case Solver::passes: return solve_passes(problem, params);
        case Solver::shooting: return solve_shooting(problem, params);
        case Solver::gauss_seidel: return solve_gauss_seidel(problem, params);
        case Solver::bicgstab: return solve_bicgstab(problem, params);
        case Solver::conjugate_gradients: return solve_conjugate_gradients(problem, params);
        case Solver::direct: return solve_direct(problem, params);
    }
    throw InputError("radiosity: no such solver");
}

}  // namespace

const char* solver_name(Solver solver) { return names[int(solver)]; }

Solver parse_solver(const std::string& name) {
    std::string all;
    for (int i = 0; i < int(std::size(names)); ++i) {
        if (name == names[i]) return Solver(i);
        all += (i ? ", " : "") + std::string(names[i]);
    }
    throw InputError(fmt::format("solver = \"{}\": expected one of {}", name, all));
}

Buffer<glm::vec4> floats_of(const Solution& solution) {
    Buffer<glm::vec4> out;
    for (const glm::dvec3& b : solution.radiosity) out.push_back(glm::vec4(glm::vec3(b), 0));
    return out;
}

Buffer<glm::vec4> shown(const Solution& solution, const System& system) {
    Buffer<glm::vec4> out = floats_of(solution);
    if (!system.reflectance || system.reflectance->size() != out.size())
        throw InputError("radiosity: shown: as many reflectances as radiosities expected");
    for (std::size_t i = 0; i < out.size(); ++i)
        out[i] = glm::vec4(glm::vec3(solution.radiosity[i] + glm::dvec3((*system.reflectance)[i]) * solution.ambient), 0);
    return out;
}

Solution solve(const System& system, const Transport& transport, const SolveParams& params, const RunOptions& options) {
    FpEnvironment environment;
    check(params);
    Problem problem(system, transport, options);
    if (problem.count == 0) {
        Solution none;
        none.converged = true, none.why = "there are no elements";
        return none;
    }
    // Passes of a given number end whatever light does.
    if (params.solver != Solver::passes || params.tolerance > 0)
        if (const int element = element_without_loss(problem); element >= 0)
            throw InputError(fmt::format("radiosity: element {}: reflects all light and sees only elements that do: "
                                         "expected a reflectance below 1, or a way out", element));
    Solution solution = run(problem, params);
    for (int i = 0; i < problem.count; ++i)
        for (int c = 0; c < 3; ++c)
            if (!(std::fabs(solution.radiosity[i][c]) <= 0x1p127))
                throw InputError(fmt::format("radiosity: {}: element {} comes to {:g} W/m2: light grows without end",
                                             solver_name(params.solver), i, solution.radiosity[i][c]));
    if (problem.progress) problem.progress(1);
    return solution;
}

Radius spectral_radius(const System& system, const Transport& transport, int most_products, const RunOptions& options) {
    FpEnvironment environment;
    Problem problem(system, transport, options);
    return power_iteration(problem, most_products);
}

}  // namespace plumb::radiosity
