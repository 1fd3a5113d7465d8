#include "tools/experiments/ipr_truth.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "tools/experiments/some_receivers.h"

namespace plumb::cli {

namespace {

// Adds a second part, whose noise is its own.
void add_part(Buffer<glm::vec4>& mean, Buffer<glm::vec4>& error, const Buffer<glm::vec4>& more, const Buffer<glm::vec4>& its_error) {
    for (std::size_t i = 0; i < mean.size(); ++i)
        for (int c = 0; c < 3; ++c) {
            const double a = error[i][c], b = its_error[i][c];
            mean[i][c] += more[i][c], error[i][c] = float(std::sqrt(a * a + b * b));
        }
}

// Without lamps: what emits, and the sky. None where nothing does.
std::unique_ptr<reference::PathScene> unlit(Scene scene, Rays rays) {
    scene.lights.clear();
    auto prepared = reference::prepare(scene, rays);
    return prepared->lights.count > 0 ? std::move(prepared) : nullptr;
}

reference::PathParams params_of(reference::Mode mode, int samples, Rays rays) {
    reference::PathParams p;
    p.mode = mode, p.samples = samples, p.rays = rays;
    return p;
}

// Those that see at most this share of the sky.
std::vector<int> not_open(const Scene& scene, const probes::Receivers& receivers, std::vector<int> index, double open, Rays rays, const RunOptions& options) {
    if (!(open < 1)) return index;
    const probes::Receivers some = some_of(receivers, index);
    Image4 position(some.count(), 1), normal(some.count(), 1);
    std::copy(some.position.begin(), some.position.end(), position.texels.begin());
    std::copy(some.normal.begin(), some.normal.end(), normal.texels.begin());
    const auto prepared = reference::prepare(scene, rays);
    const Image4 openness =
        reference::trace_irradiance(params_of(reference::Mode::ambient_occlusion, 64, rays), *prepared, {&position, &normal}, 3, options).mean;
    std::vector<int> kept;
    for (std::size_t i = 0; i < index.size(); ++i)
        if (double(openness.texels[i].x) <= open) kept.push_back(index[i]);
    if (kept.empty()) throw InputError("--open: no receiver is left");
    return kept;
}

}  // namespace

probes::ReceiverIrradiance trace_all_receivers(const Scene& scene, const probes::Receivers& receivers, int samples, Rays rays,
                                               const RunOptions& options) {
    probes::ReceiverIrradiance t = probes::receiver_irradiance(receivers, *reference::prepare(scene, rays),
                                                               params_of(reference::Mode::indirect, samples, rays), 1, options);
    if (const auto glow = unlit(scene, rays)) {
        const probes::ReceiverIrradiance d = probes::receiver_irradiance(receivers, *glow, params_of(reference::Mode::direct, samples, rays), 2, options);
        add_part(t.mean, t.error, d.mean, d.error);
    }
    return t;
}

IprTruth trace_receivers(const Scene& scene, const probes::Receivers& receivers, const IprRequest& request, Rays rays, const RunOptions& options) {
    IprTruth truth;
    const int step = (receivers.count() + request.receivers - 1) / request.receivers;
    for (int i = step / 2; i < receivers.count(); i += step) truth.index.push_back(i);
    truth.index = not_open(scene, receivers, truth.index, request.open, rays, options);
    const probes::ReceiverIrradiance t = trace_all_receivers(scene, some_of(receivers, truth.index), request.samples, rays, options);
    Image4 mean(int(truth.index.size()), 1), error = mean;
    std::copy(t.mean.begin(), t.mean.end(), mean.texels.begin());
    std::copy(t.error.begin(), t.error.end(), error.texels.begin());
    truth.mean = compare::luminances(mean), truth.error = compare::luminance_errors(error), truth.samples = t.samples;
    return truth;
}

void trace_pixels(const Scene& scene, const raster::GBuffer& seen, const IprRequest& request, Rays rays, const RunOptions& options, Image4& mean,
                  Image4& error) {
    const reference::PointInputs points{&seen.position, &seen.normal};
    const int samples = std::max(request.samples / 64, 32);
    reference::Estimate t =
        reference::trace_irradiance(params_of(reference::Mode::indirect, samples, rays), *reference::prepare(scene, rays), points, 1, options);
    mean = std::move(t.mean), error = std::move(t.error);
    if (const auto glow = unlit(scene, rays)) {
        const reference::Estimate d = reference::trace_irradiance(params_of(reference::Mode::direct, samples, rays), *glow, points, 2, options);
        add_part(mean.texels, error.texels, d.mean.texels, d.error.texels);
    }
}

}  // namespace plumb::cli
