// The steps of radiosity that no device runs: what `plumb stages` lists of them, light at elements, and the solution.
#pragma once

#include <string>

#include "core/stage.h"
#include "gi/radiosity/radiosity_params.h"
#include "gi/radiosity/solve_audit.h"
#include "gi/radiosity/solve_choose.h"

namespace plumb::radiosity {

StageInfo info_elements();
StageInfo info_rows();
StageInfo info_light();
StageInfo info_solve();

// Irradiance of elements by lamps, W/m2: where each looks from, along its normal, with shadows by rays.
Buffer<glm::vec4> lamps_at(const Scene& scene, const Elements& elements, const RunOptions& options);
// The same by the sky, of a colour everywhere: pi times its radiance times the share of texels that see nothing.
Buffer<glm::vec4> sky_at(const Scene& scene, const FormFactors& factors);

// Both must outlive it.
Transport transport_of(const FormFactors& factors, const Elements& elements);

// Before any row is made: what solves the elements' system, what that is expected to take, and why. By their count, their largest
// reflectance and the tolerance alone, so that it is the same on every machine; what the parameters ask for is what it says.
Recommendation solver_for(const Elements& elements, const RadiosityParams& params);

struct Solved {
    Solver solver = Solver::passes;
    std::string reason;    // for that solver
    Solution solution;
    float tolerance = 0;   // that it was to meet; 0: none
};
// "bicgstab: 18 products with all rows, radius 0.64, residual 2.1e-06, estimated error 5.8e-06: converged"
std::string text_of(const Solved& solved);

// B = M + rho (lamps + sky + F B). Throws InputError that names the solver, its estimated error and the tolerance, where that is not
// met; and what solve() of solve.h throws.
Solved solve(const FormFactors& factors, const Elements& elements, const Buffer<glm::vec4>& lamps, const Buffer<glm::vec4>& sky,
             const RadiosityParams& params, const RunOptions& options, Buffer<glm::vec4>& radiosity);
// Where its power goes. emitters: what `sky` has by small emitters.
Audit audit_of(const Solved& solved, const FormFactors& factors, const Elements& elements, const Buffer<glm::vec4>& lamps,
               const Buffer<glm::vec4>& sky, const Buffer<glm::vec4>& emitters, const RunOptions& options);

}  // namespace plumb::radiosity
