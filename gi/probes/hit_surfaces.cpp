#include "gi/probes/hit_surfaces.h"

#include <algorithm>

#include "core/host_math.h"
#include "core/parallel.h"
#include "core/tap.h"
#include "gi/probes/static_scene.h"
#include "gi/reference/environment_kernel.h"
#include "gi/reference/lights.h"
#include "raster/surfaces.h"

namespace plumb::probes {

namespace {

// Of B and C, by least squares, at a point of the triangle.
glm::vec2 barycentrics_of(const Geometry& geometry, int triangle, const glm::dvec3& p) {
    const glm::uvec3& t = geometry.triangles[std::size_t(triangle)];
    const glm::dvec3 a(geometry.vertices[t.x].position), e1 = glm::dvec3(geometry.vertices[t.y].position) - a,
                     e2 = glm::dvec3(geometry.vertices[t.z].position) - a, d = p - a;
    const auto dot = [](const glm::dvec3& u, const glm::dvec3& v) { return u.x * v.x + u.y * v.y + u.z * v.z; };
    const double d11 = dot(e1, e1), d12 = dot(e1, e2), d22 = dot(e2, e2), area = d11 * d22 - d12 * d12;
    if (!(area > 0)) return glm::vec2(0);
    const double b = std::clamp((d22 * dot(e1, d) - d12 * dot(e2, d)) / area, 0.0, 1.0);
    return {float(b), float(std::clamp((d11 * dot(e2, d) - d12 * dot(e1, d)) / area, 0.0, 1.0 - b))};
}

}  // namespace

void stand_in(const std::vector<std::int32_t>& ray_of, HitSurfaces& made) {
    // Those that stand for others are told by themselves: the order does not matter.
    for (Image4* image : {&made.position, &made.normal, &made.surface, &made.emitted, &made.place})
        for (std::size_t i = 0; i < ray_of.size(); ++i) image->texels[i] = image->texels[std::size_t(ray_of[i])];
}

HitSurfaces hit_surfaces(const Scene& scene, const Bake& bake, const RunOptions& options, Unasked unasked, bool normal_maps) {
    const RelightHits& hits = bake.relight;
    raster::Surfaces surfaces = raster::prepare(scene, bake.atlas.geometry);
    if (!normal_maps) drop_normal_maps(surfaces);
    const raster::SurfaceArgs args = raster::surface_args(bake.atlas.geometry, surfaces, View{});
    const reference::EnvironmentTable e = reference::environment_table(scene.environment);
    const reference::EnvironmentArgs sky = reference::environment_args(e);
    HitSurfaces made;
    for (Image4* image : {&made.position, &made.normal, &made.surface, &made.emitted, &made.place})
        *image = Image4(hits.rays, hits.probes);
    parallel_bands(hits.probes, 1, options, [&](int first, int last) {
        NoTap quiet;
        for (std::size_t i = std::size_t(first) * std::size_t(hits.rays); i < std::size_t(last) * std::size_t(hits.rays); ++i) {
            const glm::vec3 at(hits.position[i]);
            if (hits.material[i] == met_nothing && sky.width > 0)
                made.emitted.texels[i] = glm::vec4(reference::environment_radiance<float>(sky, at), 0);
            if (hits.material[i] < 0) continue;
            const int triangle = hits.triangle[i];
            const glm::vec3 from = glm::vec3(bake.placement.probes[i / std::size_t(hits.rays)]) - at;
            const auto s = raster::surface<float>(args, triangle, barycentrics_of(bake.atlas.geometry, triangle, glm::dvec3(at)),
                                                  glm::vec4(from, 0), quiet);
            made.position.texels[i] = glm::vec4(at, 0);
            made.normal.texels[i] = glm::vec4(s.normal, 1);
            made.surface.texels[i] = glm::vec4(s.albedo, 1);
            made.emitted.texels[i] = glm::vec4(s.emission * float(1 / host::pi), 0);
            made.place.texels[i] = glm::vec4(hits.uv[i], 0, 0);
        }
    });
    stand_in(stand_ins(bake, unasked, options), made);
    return made;
}

}  // namespace plumb::probes
