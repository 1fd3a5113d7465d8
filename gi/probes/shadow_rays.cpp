#include "gi/probes/shadow_rays.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "core/error.h"
#include "core/host_math.h"
#include "core/parallel.h"
#include "core/sequences.h"
#include "gi/probes/bake.h"
#include "gi/probes/hit_surfaces.h"
#include "gi/probes/receivers.h"
#include "gi/probes/run_params.h"
#include "gi/probes/sky_probe.h"
#include "gi/probes/volume_kernel.h"
#include "gi/reference/ray_query.h"
#include "gi/reference/warp_kernel.h"
#include "gi/trace_rays.h"

namespace plumb::probes {

namespace {

constexpr int turns = 16;

// [turn][ray] in the frame of a normal along z.
std::vector<glm::vec3> cosine_directions(int count) {
    std::vector<glm::vec3> all;
    for (int turn = 0; turn < turns; ++turn)
        for (int i = 0; i < count; ++i) {
            const glm::dvec2 u = hammersley(std::uint64_t(i), std::uint64_t(count));
            const double angle = 2 * host::pi * (u.y + double(turn) / turns), radius = std::sqrt(u.x);
            all.emplace_back(float(radius * host::cos(angle)), float(radius * host::sin(angle)), float(std::sqrt(1 - u.x)));
        }
    return all;
}

// max(0, a + b . w) at a point of the grid.
glm::vec3 radiance_at(const SpatialGrid& g, const Buffer<glm::vec4>& six, const glm::vec3& x, const glm::vec3& w) {
    VolumeView view{};
    view.u.count_x = g.count.x, view.u.count_y = g.count.y, view.u.count_z = g.count.z;
    for (int c = 0; c < 3; ++c) view.u.origin[c] = g.origin[c], view.u.spacing[c] = g.spacing[c];
    view.grid = &six[0].x;
    NoTap quiet;
    const SixSides<float> e = grid_at<float>(view, x, quiet);
    const auto along = [&](float xp, float xm, float yp, float ym, float zp, float zm) {
        const float a = (xp + xm + yp + ym + zp + zm) * float(1 / (6 * host::pi));
        const float b = ((xp - xm) * w.x + (yp - ym) * w.y + (zp - zm) * w.z) * float(3 / (4 * host::pi));
        return std::max(a + b, 0.0f);
    };
    return {along(e.x.plus.x, e.x.minus.x, e.y.plus.x, e.y.minus.x, e.z.plus.x, e.z.minus.x),
            along(e.x.plus.y, e.x.minus.y, e.y.plus.y, e.y.minus.y, e.z.plus.y, e.z.minus.y),
            along(e.x.plus.z, e.x.minus.z, e.y.plus.z, e.y.minus.z, e.z.plus.z, e.z.minus.z)};
}

// Of the ball around all that moves: a surface that faces away from it meets nothing.
glm::vec4 ball_around(const Geometry& geometry) {
    glm::vec3 low, high;
    if (!bounds(geometry, low, high)) return glm::vec4(0);
    const glm::vec3 half = 0.5f * (high - low);
    return glm::vec4(0.5f * (low + high), 1.001f * std::sqrt(half.x * half.x + half.y * half.y + half.z * half.z));
}

}  // namespace

std::unique_ptr<DynamicWorld> dynamic_world(const Scene& scene, const Geometry& whole) {
    auto w = std::make_unique<DynamicWorld>();
    w->offset = offset_of(extent_of(whole));
    Scene moving = scene;
    std::erase_if(moving.meshes, [](const Mesh& m) { return !m.dynamic || m.triangles.empty(); });
    if (moving.meshes.empty()) return w;
    w->geometry = flatten(moving);
    w->surfaces = raster::prepare(moving, w->geometry);
    w->query = reference::build_ray_query(w->geometry, w->surfaces, Rays::exact);
    return w;
}

void run(const ShadowRaysInputs& in, const RunOptions& options, Image4& shaded) {
    if (!in.world || !in.position || !in.normal || !in.irradiance || (in.grid && !in.six))
        throw InputError("probes.shadow_rays: world, position, normal and irradiance must be bound, and the list of a grid");
    if (in.rays < 1) throw InputError("probes.shadow_rays: no ray");
    shaded = *in.irradiance;
    if (!in.world->query) return;
    const std::vector<glm::vec3> directions = cosine_directions(in.rays);
    const glm::vec4 ball = ball_around(in.world->geometry);
    const int width = shaded.width;
    parallel_bands(shaded.height, 1, options, [&](int first, int last) {
        RayTracer<float> tracer(*in.world->query);
        for (int y = first; y < last; ++y)
            for (int px = 0; px < width; ++px) {
                const std::size_t at = std::size_t(y) * std::size_t(width) + std::size_t(px);
                const glm::vec4 normal = in.normal->texels[at];
                if (!(normal.w > 0)) continue;
                const glm::vec3 n(normal), x(in.position->texels[at]);
                if (glm::dot(n, glm::vec3(ball) - x) < -ball.w) continue;
                const reference::Basis<float> frame = reference::basis_of<float>(n);
                const glm::vec3 origin = x + n * in.world->offset;
                const glm::vec3* set = &directions[std::size_t((px % 4 + 4 * (y % 4)) * in.rays)];
                glm::vec3 sum(0);
                int hits = 0;
                for (int i = 0; i < in.rays; ++i) {
                    const glm::vec3 w = reference::to_world<float>(frame, set[i]);
                    const RayHit<float> hit = tracer.nearest(origin, w, true);
                    if (!hit.found) continue;
                    ++hits;
                    if (in.grid) sum += radiance_at(*in.grid, *in.six, origin + w * hit.t, w);
                }
                if (hits == 0) continue;
                const glm::vec4 e = in.irradiance->texels[at];
                const glm::vec3 left = in.grid ? glm::vec3(e) - sum * float(host::pi / in.rays) : glm::vec3(e) * (1 - float(hits) / float(in.rays));
                shaded.texels[at] = glm::vec4(glm::max(left, glm::vec3(0)), e.w);
            }
    });
}

std::size_t meet_dynamic(const DynamicWorld& world, const Bake& bake, const RunOptions& options, HitSurfaces& made) {
    if (!world.query) return 0;
    const RelightHits& hits = bake.relight;
    const raster::SurfaceArgs surfaces = raster::surface_args(world.geometry, world.surfaces, View{});
    std::atomic<std::size_t> met{0};
    parallel_bands(hits.probes, 1, options, [&](int first, int last) {
        RayTracer<float> tracer(*world.query);
        NoTap quiet;
        std::size_t mine = 0;
        for (std::size_t i = std::size_t(first) * std::size_t(hits.rays); i < std::size_t(last) * std::size_t(hits.rays); ++i) {
            const glm::vec4 probe = bake.placement.probes[i / std::size_t(hits.rays)];
            if (is_sky(probe)) continue;
            const glm::vec3 origin(probe), end(hits.position[i]);
            const bool escapes = hits.material[i] == met_nothing;
            const glm::vec3 to = escapes ? end : end - origin;  // of what met nothing its direction is kept
            const RayHit<float> hit = tracer.nearest(origin, to, true);
            if (!hit.found || (!escapes && hit.t >= 1)) continue;
            const auto s = raster::surface<float>(surfaces, hit.triangle, hit.barycentrics, glm::vec4(-to, 0), quiet);
            const bool front = dot3(s.face, to) < 0;
            made.position.texels[i] = front ? glm::vec4(s.position, 0) : glm::vec4(0);
            made.normal.texels[i] = front ? glm::vec4(s.normal, 1) : glm::vec4(0);
            made.surface.texels[i] = front ? glm::vec4(s.albedo, 1) : glm::vec4(0);
            made.emitted.texels[i] = front ? glm::vec4(s.emission * float(1 / host::pi), 0) : glm::vec4(0);
            ++mine;
        }
        met += mine;
    });
    return met;
}

StageInfo info_shadow_rays() {
    RunParams defaults;
    StageInfo info;
    info.name = "probes.shadow_rays";
    info.source = "beyond IPR (its 6.1); without a twin: rays against dynamic meshes";
    info.inputs = {{"position", "image rgba32f", "m", "world-space position"}, {"normal", "image rgba32f", "", "unit normal; w 1: a point"},
                   {"irradiance", "image rgba32f", "W/m2", "E, without shadows of what moves"},
                   {"grid", "buffer f32 x 4", "W/m2", "[place][direction] irradiance of spatial receivers"}};
    info.outputs = {{"shaded", "image rgba32f", "W/m2", "E', what is left"}};
    info.params = describe(fields(defaults), {"indirect_shadow", "shadow_rays"});
    return info;
}

}  // namespace plumb::probes
