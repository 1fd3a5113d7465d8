#include "gi/probes/texture_rays.h"

#include <fmt/format.h>

#include <cstring>

#include "core/error.h"
#include "core/host_math.h"
#include "gi/probes/directions.h"
#include "gi/probes/lambda.h"
#include "gi/probes/relight.h"
#include "gi/probes/sky_probe.h"
#include "gi/probes/stand_in.h"
#include "gi/reference/environment_kernel.h"
#include "gi/reference/lights.h"

namespace plumb::probes {

RayTables ray_tables(const BakeArrays& a, const std::vector<int>& level_rays) {
    RayTables t;
    t.probes = int(a.probes.size()), t.rays = a.rays, t.coefficients = a.coefficients;
    int degree = 0;
    while ((degree + 1) * (degree + 1) < a.coefficients) ++degree;
    if ((degree + 1) * (degree + 1) != a.coefficients)
        throw InputError(fmt::format("spherical_harmonics: {} coefficients: expected the square of a number", a.coefficients));
    const Buffer<glm::vec4> directions = relight_directions(a.rays);
    t.harmonics = harmonics_of(directions, degree);
    for (std::size_t i = 0; i < t.harmonics.size(); ++i)
        if (std::memcmp(&t.harmonics[i], &a.sh[i], sizeof(float)) != 0)
            throw InputError(fmt::format("spherical_harmonics: texel {}, {} is {:g}: Y of relight ray {} is {:g}", i / std::size_t(a.coefficients),
                                         i % std::size_t(a.coefficients), a.sh[i], i / std::size_t(a.coefficients), t.harmonics[i]));
    t.weights = level_weights(directions, level_rays);
    return t;
}

RaySurfaces ray_surfaces(const BakeArrays& a, const Scene& scene, Escape escape, Unasked unasked) {
    const reference::EnvironmentTable e = reference::environment_table(scene.environment);
    const reference::EnvironmentArgs around = reference::environment_args(e);
    const Buffer<glm::vec4> directions = relight_directions(a.rays);
    const glm::vec4 nothing(0);
    RaySurfaces s;
    std::vector<std::int32_t> material;
    for (const BakedRay& ray : a.relight) material.push_back(ray.material);
    const bool with_sky = !a.probes.empty() && is_sky(glm::vec4(a.probes.back(), 0));
    const std::vector<std::uint8_t> asked = asked_rays(material, a.rays, int(a.probes.size()) - (with_sky ? 1 : 0), escape, unasked);
    s.surface.assign(a.relight.size(), nothing), s.emitted.assign(a.relight.size(), nothing), s.place.assign(a.relight.size(), nothing);
    for (std::size_t i = 0; i < a.relight.size(); ++i) {
        const BakedRay& ray = a.relight[i];
        if (ray.material == met_nothing && around.width > 0)
            s.emitted[i] = glm::vec4(reference::environment_radiance<float>(around, glm::vec3(directions[i % std::size_t(a.rays)])), 0);
        if (ray.material < 0) continue;
        if (std::size_t(ray.material) >= scene.materials.size())
            throw InputError(fmt::format("probe_rays: ray {}: material {} of {}", i, ray.material, scene.materials.size()));
        const Material& m = scene.materials[std::size_t(ray.material)];
        if (m.texture >= 0 || m.emission_texture >= 0)
            throw InputError(fmt::format("probe_rays: ray {}: material {} has a texture: no data texture says where on it a ray ends", i, ray.material));
        s.surface[i] = glm::vec4(m.reflectance + 0.0f, 1);
        s.emitted[i] = glm::vec4((m.emission + 0.0f) * float(1 / host::pi), 0);
        s.place[i] = glm::vec4(ray.uv, 0, 0);
    }
    const std::vector<std::int32_t> ray_of = stand_ins(directions, asked, {});
    for (Buffer<glm::vec4>* list : {&s.surface, &s.emitted, &s.place})
        for (std::size_t i = 0; i < list->size(); ++i) (*list)[i] = (*list)[std::size_t(ray_of[i])];
    return s;
}

}  // namespace plumb::probes
