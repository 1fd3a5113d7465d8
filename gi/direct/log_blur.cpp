#include "gi/direct/log_blur.h"

#include <algorithm>
#include <cmath>

#include "core/host_math.h"

namespace plumb::direct {

namespace {

// Exponents stay normal numbers, and their quotients finite, for the depths of any scene.
float per_metre(float c, double range) { return float(std::clamp(double(c) / range, 1e-30, 1e30)); }

}  // namespace

bool blurs_maps(const ShadowParams& params) { return params.mode == ShadowMode::esm && params.esm_blur_radius > 0; }

double depth_range(std::span<const raster::Rsm> rsms) {
    double range = 0;
    for (const raster::Rsm& rsm : rsms) {
        const View& v = rsm.view;
        // Clip depth of a box runs from 0 to 1.
        const double far = v.orthographic ? 1 / std::abs(v.view_to_clip[2][2]) : v.far;
        if (far < unbounded) range = std::max(range, far);
    }
    return range > 0 ? range : 1;
}

float c_per_metre(const ShadowParams& params, std::span<const raster::Rsm> rsms) {
    return per_metre(params.esm_c, depth_range(rsms));
}

Buffer<float> blur_weights(const ShadowParams& params) {
    const double sigma = params.esm_blur_sigma;
    Buffer<float> weights;
    for (int i = -params.esm_blur_radius; i <= params.esm_blur_radius; ++i)
        weights.push_back(std::max(float(host::exp(-(i * i) / (2 * sigma * sigma))), 0x1p-100f));
    return weights;
}

StageData data_of(const ShadowParams& params, const LogBlurInputs& in) {
    ShadowParams copy = params;
    validate_fields(log_blur_stage, fields(copy));
    const glm::ivec2 size = size_of(bound(log_blur_stage, "map", in.map));
    if (!(in.range > 0 && in.range < unbounded))
        throw InputError(fmt::format("{}: range = {} m: expected a finite length above 0", log_blur_stage, in.range));
    StageData d = begin_data<LogBlurKernel>(
        size, LogBlurUniforms{size.x, size.y, params.esm_blur_radius, in.direction == Direction::vertical ? 1 : 0,
                              per_metre(params.esm_c, in.range), {}});
    lend(d, {{"depth_map", in.map}});
    const Buffer<float> spatial = blur_weights(params);
    add(d.inputs, "spatial", {int(spatial.size())}, spatial.data());
    return d;
}

void blur_maps(const ShadowParams& params, std::span<const raster::Rsm> rsms, const RunOptions& options,
               std::vector<Image4>& blurred) {
    blurred.assign(rsms.size(), {});
    const double range = depth_range(rsms);
    for (std::size_t m = 0; m < rsms.size(); ++m) {
        if (rsms[m].size == 0) continue;
        Image4 across;
        run(params, LogBlurInputs{&rsms[m].position, Direction::horizontal, range}, options, across);
        run(params, LogBlurInputs{&across, Direction::vertical, range}, options, blurred[m]);
    }
}

}  // namespace plumb::direct
