#include "gi/radiosity/host_stages.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/host_math.h"
#include "gi/probes/host_step.h"
#include "gi/probes/lit_hits.h"
#include "gi/radiosity/gather.h"

namespace plumb::radiosity {

namespace {

constexpr auto step = probes::host_step<RadiosityParams>;

const Port elements = {"elements", "arrays", "", "positions, normals, materials"};

// What elements get that is not reflected by others.
Buffer<glm::vec4> incident_of(const Buffer<glm::vec4>& lamps, const Buffer<glm::vec4>& sky) {
    Buffer<glm::vec4> incident(lamps.size());
    for (std::size_t i = 0; i < incident.size(); ++i) incident[i] = glm::vec4(glm::vec3(lamps[i]) + glm::vec3(sky[i]), 0);
    return incident;
}

float largest_reflectance(const Elements& elements) {
    float largest = 0;
    for (const glm::vec4& rho : elements.reflectance) largest = std::max(largest, std::max(rho.x, std::max(rho.y, rho.z)));
    return largest;
}

}  // namespace

Buffer<glm::vec4> lamps_at(const Scene& scene, const Elements& elements, const RunOptions& options) {
    const int n = elements.count();
    if (n == 0) return {};
    const auto lit = probes::lit_scene(scene, Rays::exact);
    Image4 position(n, 1), normal(n, 1);
    for (int i = 0; i < n; ++i) position(i, 0) = elements.eye[std::size_t(i)], normal(i, 0) = elements.normal[std::size_t(i)];
    const Image4 sum = probes::lamp_irradiance(*lit, position, normal, options);
    return Buffer<glm::vec4>(sum.texels.begin(), sum.texels.end());
}

Buffer<glm::vec4> sky_at(const Scene& scene, const FormFactors& factors) {
    Buffer<glm::vec4> sky;
    const glm::dvec3 full = host::pi * glm::dvec3(scene.environment.radiance);
    for (const float escaped : factors.escaped) sky.push_back(glm::vec4(glm::vec3(double(escaped) * full), 0));
    return sky;
}

Transport transport_of(const FormFactors& factors, const Elements& elements) {
    Transport t;
    t.count = factors.count, t.area = &elements.area, t.row_sums = &factors.sums;
    // A row's numbers go to row_lanes sums in turns, which are added.
    t.gather_loss = 0x1p-24 * std::sqrt(factors.longest / double(row_lanes) + 5);
    t.gather = [&factors, none = Buffer<glm::vec4>(std::size_t(factors.count), glm::vec4(0))](
                   const Buffer<glm::vec4>& b, Buffer<glm::vec4>& h, const RunOptions& options) { gather(factors, none, b, options, h); };
    t.row = [&factors](int i, std::vector<float>& row) {
        row.assign(std::size_t(factors.count), 0.0f);
        factors.add_row(i, row);
    };
    return t;
}

Recommendation solver_for(const Elements& elements, const RadiosityParams& params) {
    TransportFacts facts;
    facts.count = elements.count(), facts.row_bytes = std::int64_t(bytes_expected(facts.count, params.size));
    facts.largest_reflectance = double(largest_reflectance(elements)), facts.tolerance = double(params.tolerance);
    const bool asked = params.solver != SolverChoice::automatic;
    if (!(params.tolerance > 0)) {
        const Solver solver = asked ? Solver(int(params.solver) - 1) : Solver::passes;
        return {solver, double(params.passes), 0, fmt::format("tolerance = 0: {} {}, whatever is left", params.passes,
                                                               solver == Solver::passes ? "passes from black" : "products with all rows")};
    }
    Recommendation best = recommend(facts);
    if (!asked) return best;
    const Solver solver = Solver(int(params.solver) - 1);
    if (solver == best.solver) return best;
    return {solver, 0, 0, fmt::format("solver = {}; recommended is {}: {}", solver_name(solver), solver_name(best.solver), best.reason)};
}

std::string text_of(const Solved& s) {
    const Solution& x = s.solution;
    const bool known = x.radius.products > 0, averaged = x.row_residual > 2 * x.residual;
    return fmt::format("{}: {:.4g} product{} with all rows, radius {:.6g}{}, residual {:.2g}{}, estimated error {:.2g}: {}", solver_name(s.solver),
                       x.products, x.products == 1 ? "" : "s", known ? x.radius.value : x.radius.high, known ? "" : " at most", x.residual,
                       averaged ? fmt::format(" ({:.2g} of rows that are not reciprocal)", x.row_residual) : "", x.error,
                       x.converged ? "converged" : "as many as were asked for");
}

Solved solve(const FormFactors& factors, const Elements& elements, const Buffer<glm::vec4>& lamps, const Buffer<glm::vec4>& sky,
             const RadiosityParams& params, const RunOptions& options, Buffer<glm::vec4>& radiosity) {
    const Buffer<glm::vec4> incident = incident_of(lamps, sky);
    const System system{&elements.reflectance, &elements.exitance, &incident};
    const Recommendation choice = solver_for(elements, params);
    Solved solved{choice.solver, choice.reason, {}, params.tolerance};
    SolveParams how;
    how.solver = choice.solver, how.tolerance = double(params.tolerance), how.most_products = params.passes;
    how.most_bytes = std::int64_t(params.memory_mb) * 1'000'000;
    Solution& s = solved.solution;
    s = solve(system, transport_of(factors, elements), how, options);
    if (params.tolerance > 0 && !s.converged)
        throw InputError(fmt::format("radiosity: {}: not converged after {:.4g} products with all rows: {}: expected at most tolerance = {}, with more "
                                     "passes than {}, or another solver ({})", solver_name(solved.solver), s.products, s.why, params.tolerance,
                                     params.passes, solver_name(solver_for(elements, {.tolerance = params.tolerance}).solver)));
    radiosity = shown(s, system);
    return solved;
}

Audit audit_of(const Solved& solved, const FormFactors& factors, const Elements& elements, const Buffer<glm::vec4>& lamps,
               const Buffer<glm::vec4>& sky, const Buffer<glm::vec4>& emitters, const RunOptions& options) {
    const Buffer<glm::vec4> incident = incident_of(lamps, sky);
    return audit({&elements.reflectance, &elements.exitance, &incident}, transport_of(factors, elements), solved.solution.radiosity, 512, options,
                 {&elements.lamp_exitance, &emitters});
}

StageInfo info_elements() {
    return step("radiosity.elements", "HEM 4.5.4, 5.5; without a twin: the mesh's vertices, split at creases and moved off their surface, when it changes",
                {{"scene", "meshes", "", "of all triangles"}}, {{"eye", "buffer f32 x 4", "m", "where each element's hemicube stands"}},
                {"elements", "crease_deg", "offset", "inset", "split", "small_emitters"});
}

StageInfo info_rows() {
    return step("radiosity.rows", "HEM 4.5.3, 5.6; without a twin: radiosity.items tells what each texel sees, the host sums and packs it", {elements},
                {{"weights", "buffer f16", "", "form factors, run by run"}}, {"size", "weights", "memory_mb"});
}

StageInfo info_light() {
    return step("radiosity.light", "HEM 4.5.4 has emitters alone; without a twin: rays from elements to lamps and small emitters", {elements},
                {{"lamps", "buffer f32 x 4", "W/m2", "irradiance by lamps"}, {"sky", "buffer f32 x 4", "W/m2", "irradiance by the sky and small emitters"}}, {});
}

StageInfo info_solve() {
    return step("radiosity.solve", "HEM 4.5.4; without a twin: passes, or another solver, that run radiosity.gather until little is left", {elements},
                {{"radiosity", "buffer f32 x 4", "W/m2", "what leaves each element"}}, {"solver", "tolerance", "passes", "audit"});
}

}  // namespace plumb::radiosity
