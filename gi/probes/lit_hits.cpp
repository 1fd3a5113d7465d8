#include "gi/probes/lit_hits.h"

#include <fmt/format.h>

#include <atomic>
#include <cmath>

#include "core/error.h"
#include "core/host_math.h"
#include "core/parallel.h"
#include "gi/probes/receivers.h"
#include "gi/probes/sky_probe.h"
#include "gi/reference/light_kernel.h"
#include "gi/reference/ray_query.h"
#include "gi/trace_rays.h"

namespace plumb::probes {

std::unique_ptr<LitScene> lit_scene(const Scene& scene, Rays rays) {
    auto s = std::make_unique<LitScene>();
    s->geometry = flatten(scene);
    if (s->geometry.triangles.empty()) throw InputError(scene.name + ": no surface");
    s->surfaces = raster::prepare(scene, s->geometry);
    s->environment = reference::environment_table(scene.environment);
    s->lights = reference::light_table(scene, s->geometry, s->surfaces, s->environment);
    s->query = reference::build_ray_query(s->geometry, s->surfaces, rays);
    s->offset = offset_of(extent_of(s->geometry));
    return s;
}

namespace {

// One ray at a time: what is asked of surfaces and lights.
class Asker {
  public:
    explicit Asker(const LitScene& scene)
        : scene_(scene), surfaces_(raster::surface_args(scene.geometry, scene.surfaces, View{})), tracer_(*scene.query) {
        const reference::LightTable& t = scene.lights;
        lights_ = {t.count, 0, t.rows.data(), t.cdf.data(), t.triangle_pdf.data(), t.environment_probability, t.any_radius};
        sky_ = reference::environment_args(scene.environment);
    }

    glm::vec3 lamps(const glm::vec3& x, const glm::vec3& n) {
        glm::vec3 sum(0);
        const glm::vec3 origin = x + n * scene_.offset;
        for (int i = 0; i < lights_.count; ++i) {
            const int kind = int(lights_.rows[16 * std::ptrdiff_t(i) + 11]);
            if (kind != int(reference::LightKind::lamp) && kind != int(reference::LightKind::directional)) continue;
            const auto s = reference::sample_light<float>(lights_, surfaces_, sky_, {i, 1.0f, 0.0f}, 0.0f, x);
            const float cosine = dot3(n, s.direction);
            if (!(cosine > 0) || s.radiance == glm::vec3(0)) continue;
            const glm::vec3 to = s.infinite ? s.direction : s.target - origin;
            const float end = s.infinite ? __builtin_inff() : 1.0f;
            if (tracer_.visible(origin, to, 0.0f, end, true)) sum += s.radiance * cosine;
        }
        return sum;
    }

    void ask(const glm::vec3& origin, const glm::vec3& direction, std::size_t at, LitHits& hits) {
        const RayHit<float> hit = is_sky(glm::vec4(origin, 0)) ? RayHit<float>{} : tracer_.nearest(origin, direction, true);
        hits.towards.texels[at] = glm::vec4(-direction, hit.t);
        if (!hit.found) {
            if (sky_.width > 0)
                hits.emitted.texels[at] = glm::vec4(reference::environment_radiance<float>(sky_, direction), 0);
            return;
        }
        NoTap quiet;
        const auto s = raster::surface<float>(surfaces_, hit.triangle, hit.barycentrics, glm::vec4(-direction, 0), quiet);
        const bool front = dot3(s.face, direction) < 0;
        hits.position.texels[at] = glm::vec4(s.position, front ? 1.0f : -1.0f);
        if (!front) return;
        hits.normal.texels[at] = glm::vec4(s.normal, 0);
        hits.albedo.texels[at] = glm::vec4(s.albedo, 0);
        hits.emitted.texels[at] = glm::vec4(s.emission * float(1 / host::pi), 0);
        hits.direct.texels[at] = glm::vec4(lamps(s.position, s.normal), 0);
    }

    std::uint64_t traced() const { return tracer_.traced(); }

  private:
    const LitScene& scene_;
    raster::SurfaceArgs surfaces_;
    reference::LightArgs lights_{};
    reference::EnvironmentArgs sky_{};
    RayTracer<float> tracer_;
};

}  // namespace

LitHits lit_hits(const LitScene& scene, const Buffer<glm::vec4>& origins, const Buffer<glm::vec4>& directions,
                 const RunOptions& options) {
    if (origins.empty() || directions.empty() || origins.size() > 32767 || directions.size() > 32767)
        throw InputError(fmt::format("{} probes with {} rays each: expected 1 to 32767 of both", origins.size(), directions.size()));
    const int width = int(directions.size()), height = int(origins.size());
    LitHits hits;
    for (Image4* image : {&hits.position, &hits.normal, &hits.towards, &hits.albedo, &hits.emitted, &hits.direct})
        *image = Image4(width, height);
    std::atomic<std::uint64_t> rays{0};
    parallel_bands(height, 1, options, [&](int first, int last) {
        Asker asker(scene);
        for (int p = first; p < last; ++p)
            for (int k = 0; k < width; ++k)
                asker.ask(glm::vec3(origins[std::size_t(p)]), glm::vec3(directions[std::size_t(k)]),
                          std::size_t(p) * std::size_t(width) + std::size_t(k), hits);
        rays += asker.traced();
    });
    hits.rays = rays;
    return hits;
}

Image4 lamp_irradiance(const LitScene& scene, const Image4& position, const Image4& normal, const RunOptions& options,
                       std::uint64_t* rays) {
    if (position.width != normal.width || position.height != normal.height)
        throw InputError("lamp_irradiance: position and normal of different sizes");
    Image4 out(position.width, position.height);
    std::atomic<std::uint64_t> traced{0};
    parallel_bands(position.height, 1, options, [&](int first, int last) {
        Asker asker(scene);
        for (int y = first; y < last; ++y)
            for (int x = 0; x < position.width; ++x) {
                const glm::vec3 n(normal(x, y));
                if (n != glm::vec3(0)) out(x, y) = glm::vec4(asker.lamps(glm::vec3(position(x, y)), n), 0);
            }
        traced += asker.traced();
    });
    if (rays) *rays = traced;
    return out;
}

}  // namespace plumb::probes
