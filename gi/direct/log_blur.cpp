#include "gi/direct/log_blur.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/fp_environment.h"
#include "core/host_math.h"
#include "core/parallel.h"
#include "gi/direct/bindings.h"
#include "gi/direct/direct_rows.h"

namespace plumb::direct {

namespace {

constexpr int band = 16;

LogBlurInputsView view_of(const ShadowParams& params, const LogBlurInputs& in, const Buffer<float>& spatial) {
    return {log_blur_uniforms(params, in), &in.map->data()->x, spatial.data(), nullptr};
}

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

LogBlurUniforms log_blur_uniforms(const ShadowParams& params, const LogBlurInputs& in) {
    return {in.map->width, in.map->height, params.esm_blur_radius, in.direction == Direction::vertical ? 1 : 0,
            per_metre(params.esm_c, in.range), {}};
}

void validate(const ShadowParams& params, const LogBlurInputs& in) {
    ShadowParams copy = params;
    validate_fields("shadow.blur", fields(copy));
    if (!in.map || in.map->empty()) throw InputError("shadow.blur: map must be bound");
    if (!(in.range > 0 && in.range < unbounded))
        throw InputError(fmt::format("shadow.blur: range = {} m: expected a finite length above 0", in.range));
}

void run(const ShadowParams& params, const LogBlurInputs& in, const RunOptions& options, Image4& blurred) {
    validate(params, in);
    const Buffer<float> spatial = blur_weights(params);
    Image4 result(in.map->width, in.map->height);
    LogBlurInputsView view = view_of(params, in, spatial);
    view.blurred = &result.data()->x;
    dispatch(options.isa, [&](auto isa) {
        parallel_bands(result.height, band, options,
                       [&](int first, int last) { Rows<isa()>::log_blur(view, first, last); });
    });
    blurred = std::move(result);
}

void blur_maps(const ShadowParams& params, std::span<const raster::Rsm> rsms, const RunOptions& options,
               std::vector<Image4>& blurred) {
    blurred.assign(rsms.size(), {});
    const double range = depth_range(rsms);
    for (std::size_t m = 0; m < rsms.size(); ++m) {
        if (rsms[m].size == 0) continue;
        Image4 across;
        run(params, {&rsms[m].position, Direction::horizontal, range}, options, across);
        run(params, {&across, Direction::vertical, range}, options, blurred[m]);
    }
}

std::vector<TapValue> explain(const ShadowParams& params, const LogBlurInputs& in, glm::ivec2 texel) {
    validate(params, in);
    const Buffer<float> spatial = blur_weights(params);
    FpEnvironment environment;
    Recorder recorder;
    log_blur<float>(view_of(params, in, spatial), texel.x, texel.y, recorder);
    return recorder.values;
}

StageInfo log_blur_info() {
    ShadowParams defaults;
    StageInfo s;
    s.name = "shadow.blur";
    s.source = "ISR 4.6 (logarithmic blur of the shadow map)";
    s.inputs = {{"depth_map", "image rgba32f", "m", "w: linear light-space depth; 0 where nothing is"},
                {"spatial", "buffer f32", "", "Gaussian of the distance along the row or the column"}};
    s.outputs = {{"blurred", "image rgba32f", "m", "w: blurred depth; 0 where no tap has anything"}};
    for (const Field& f : fields(defaults))
        if (f.name == "esm_c" || f.name == "esm_blur_radius" || f.name == "esm_blur_sigma")
            s.params.push_back(describe({f}).front());
    s.twin = "gi/direct/log_blur.comp";
    return s;
}

}  // namespace plumb::direct
