// plumb experiment isr: what image-space radiosity means to compute, traced.
#include <algorithm>
#include <cmath>

#include "core/host_math.h"
#include "gi/frame/truth.h"
#include "tools/experiments/isr.h"

namespace plumb::cli {

namespace {

// Diffuse surfaces, and what they emit alone.
Scene emitters_only(Scene scene) {
    scene.lights.clear(), scene.environment = {};
    for (Material& m : scene.materials) m.specular = m.mirror = glm::vec3(0);
    return scene;
}

bool emits(const Scene& scene) {
    return std::any_of(scene.materials.begin(), scene.materials.end(),
                       [](const Material& m) { return m.emission != glm::vec3(0); });
}
bool shines(const Scene& scene) {
    return std::any_of(scene.lights.begin(), scene.lights.end(),
                       [](const Light& l) { return l.on && l.intensity != glm::vec3(0); });
}

// Adds an estimate that is independent of the sum.
void add(const reference::Estimate& part, reference::Estimate& sum) {
    for (std::size_t i = 0; i < sum.mean.size(); ++i) {
        sum.mean.texels[i] += part.mean.texels[i];
        for (int c = 0; c < 3; ++c) {
            const double a = double(sum.error.texels[i][c]), b = double(part.error.texels[i][c]);
            sum.error.texels[i][c] = float(std::sqrt(a * a + b * b));
        }
    }
    sum.samples = std::max(sum.samples, part.samples), sum.rays += part.rays, sum.nonfinite += part.nonfinite;
}

reference::Estimate traced(const Scene& scene, const reference::PointInputs& points, reference::Mode mode, int bounces, int samples,
                           const RunOptions& options) {
    reference::PathParams params;
    params.mode = mode, params.max_bounces = bounces, params.samples = samples;
    const std::unique_ptr<reference::PathScene> paths = reference::prepare(scene, params.rays);
    return reference::trace_irradiance(params, *paths, points, scene.seed, options);
}

}  // namespace

reference::Estimate isr_own_irradiance(const Scene& scene, const reference::PointInputs& points, int bounces, bool direct,
                                       int samples, const RunOptions& options) {
    using reference::Mode;
    reference::Estimate sum;
    sum.mean = sum.error = Image4(points.position->width, points.position->height);
    if (shines(scene)) {
        const Mode mode = direct ? Mode::all : bounces == 1 ? Mode::one_bounce : Mode::indirect;
        add(traced(frame::lamps_only(scene), points, mode, bounces, samples, options), sum);
    }
    // What emits is a source of the first gather: its light is reflected once less than that of lamps.
    if (emits(scene))
        add(traced(emitters_only(scene), points, bounces == 1 ? Mode::direct : Mode::all, bounces - 1, samples, options), sum);
    return sum;
}

reference::Estimate isr_own_picture(const Scene& scene, const frame::Frame& frame, int bounces, int samples,
                                    const RunOptions& options) {
    const raster::GBuffer& g = frame.gbuffer;
    reference::Estimate picture = isr_own_irradiance(scene, {&g.position, &g.normal}, bounces, true, samples, options);
    const float per_pi = float(1 / host::pi);
    for (std::size_t i = 0; i < picture.mean.size(); ++i) {
        glm::vec4 &mean = picture.mean.texels[i], &error = picture.error.texels[i];
        if (g.normal.texels[i].w == 0) {
            mean = glm::vec4(scene.environment.radiance, 0), error = glm::vec4(0);
            continue;
        }
        for (int c = 0; c < 3; ++c) {
            const float rho = g.albedo.texels[i][c] * per_pi;
            mean[c] = rho * mean[c] + g.emission.texels[i][c] * per_pi, error[c] *= rho;
        }
    }
    return picture;
}

}  // namespace plumb::cli
