// The scene that radiosity draws (HEM 4.5.4, step 1): split evenly, cut at contacts, and split again where light changes.
#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "gi/radiosity/cut_contacts.h"
#include "gi/radiosity/gather.h"
#include "gi/radiosity/host_stages.h"
#include "gi/radiosity/lamp_light.h"
#include "gi/radiosity/own_light.h"
#include "gi/radiosity/tessellate.h"

namespace plumb::radiosity {
namespace {

constexpr int refining_size = 16;            // texels of a hemicube's side: triangles are chosen by differences of a tenth
constexpr float refining_error = 1e-2f;      // of what is solved to choose them
constexpr double least_of_edge = 1.0 / 8;
constexpr double dark = 0.05;                // of the scene's mean: less counts as so much

// What is interpolated on triangles: irradiance but by lamps, which shadow maps bring to the picture.
Buffer<glm::vec4> irradiance_of(const Scene& scene, const Elements& elements, RadiosityParams params, const RunOptions& options) {
    params.size = std::min(params.size, refining_size), params.tolerance = std::max(params.tolerance, refining_error);
    params.solver = SolverChoice::automatic, params.passes = RadiosityParams{}.passes;
    const FormFactors factors = form_factors(elements, row_params(params), options);
    const Buffer<glm::vec4> lamps = lamps_on(scene, elements, options);
    const Buffer<glm::vec4> own = own_light(scene, elements, factors, params, options);
    Buffer<glm::vec4> radiosity, irradiance;
    solve(factors, elements, lamps, own, params, options, radiosity);
    gather(factors, own, radiosity, options, irradiance);
    return irradiance;
}

}  // namespace

Scene drawn_by_radiosity(const Scene& scene, const RadiosityParams& params, const RunOptions& options) {
    if (!scene.animation.meshes.empty())
        throw InputError(scene.name + ": method radiosity: meshes move: expected a scene that stands still");
    glm::vec3 low, high;
    if (!bounds(flatten(scene), low, high)) return scene;
    const glm::dvec3 size = glm::dvec3(high) - glm::dvec3(low);
    const double edge = params.edge > 0 ? double(params.edge) : std::sqrt(glm::dot(size, size)) / automatic_edges;
    Scene drawn = tessellate(scene, {edge, params.most_triangles});
    if (params.cut) drawn = cut_contacts(drawn, params.most_triangles).scene;
    RefineParams by;
    by.tolerance = double(params.refine_tolerance), by.dark = dark, by.contacts = !params.cut, by.most_triangles = params.most_triangles;
    by.least_edge = params.least_edge > 0 ? double(params.least_edge) : least_of_edge * edge;
    for (int round = 0; round < params.refine; ++round) {
        const Elements elements = elements_of(drawn, element_params(params), options);
        Buffer<glm::vec4> irradiance;
        try {
            irradiance = irradiance_of(drawn, elements, params, options);
        } catch (const InputError& error) {
            throw InputError(scene.name + ": " + error.what());
        }
        Refined finer = refine(drawn, elements, irradiance, by);
        if (finer.different + finer.at_contacts + finer.beside == 0) break;
        drawn = std::move(finer.scene);
    }
    return drawn;
}

}  // namespace plumb::radiosity
