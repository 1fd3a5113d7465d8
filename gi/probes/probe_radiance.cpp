#include "gi/probes/probe_radiance.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"
#include "gi/probes/lit_hits.h"
#include "gi/probes/sky_probe.h"
#include "gi/probes/stand_in.h"

namespace plumb::probes {
namespace {

constexpr int most_rounds = 300, probes_at_once = 64;
constexpr double at_rest = 1e-5;

}  // namespace

Relit lit_relight(const Bake& bake, const Scene& scene, const RunOptions& options) {
    const std::unique_ptr<LitScene> lit = lit_scene(scene, bake.params.rays);
    const Buffer<glm::vec4>& probes = bake.placement.probes;
    Relit relit;
    const auto append = [](const Image4& from, std::vector<glm::dvec3>& to) {
        for (const glm::vec4& t : from.texels) to.emplace_back(t);
    };
    for (std::size_t first = 0; first < probes.size(); first += probes_at_once) {
        const std::size_t end = std::min(first + probes_at_once, probes.size());
        const Buffer<glm::vec4> some(probes.begin() + std::ptrdiff_t(first), probes.begin() + std::ptrdiff_t(end));
        const LitHits hits = lit_hits(*lit, some, bake.relight_directions, options);
        append(hits.emitted, relit.emitted), append(hits.albedo, relit.reflectance), append(hits.direct, relit.direct);
    }
    return relit;
}

ProbeRadiance probe_radiance(const Bake& bake, const Scene& scene, const RunOptions& options) {
    if (bake.params.degree < 2)
        throw InputError(fmt::format("probes.degree = {}: the coefficients of engines are of degree 2; expected 2 to 7", bake.params.degree));
    RunTime light(bake, lit_relight(bake, scene, options), Transport::whole, stand_ins(bake, Unasked::nearest, options));
    ProbeRadiance result;
    result.rounds = light.converge(most_rounds, at_rest);
    if (result.rounds == most_rounds)
        throw InputError(fmt::format("{}: light does not come to rest in {} rounds: its surfaces reflect all that they get, or more",
                                     scene.name, most_rounds));
    const std::vector<glm::dvec3> lambda = light.lambda_everywhere();
    const std::size_t coefficients = std::size_t(bake.coefficients());
    for (std::size_t p = 0; p < std::size_t(standing_probes(bake.placement.probes)); ++p) {
        result.position.emplace_back(bake.placement.probes[p]);
        Radiance9& of_probe = result.radiance.emplace_back();
        for (std::size_t i = 0; i < of_probe.size(); ++i) of_probe[i] = lambda[p * coefficients + i];
    }
    return result;
}

}  // namespace plumb::probes
