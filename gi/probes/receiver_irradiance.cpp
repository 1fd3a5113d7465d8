#include "gi/probes/receiver_irradiance.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace plumb::probes {

namespace {

constexpr int longest_row = 64;  // a task takes eight rows

// Rows of nearly equal length: what fills the last one up has no normal, and is not traced.
glm::ivec2 grid_of(int count) {
    const int rows = (count + longest_row - 1) / longest_row;
    return {(count + rows - 1) / rows, rows};
}

Image4 on_grid(const Buffer<glm::vec4>& values, glm::ivec2 grid) {
    Image4 image(grid.x, grid.y, glm::vec4(0));
    std::copy(values.begin(), values.end(), image.texels.begin());
    return image;
}

double relative_error(const ReceiverIrradiance& e) {
    double variances = 0, total = 0;
    for (std::size_t i = 0; i < e.mean.size(); ++i)
        for (int c = 0; c < 3; ++c)
            variances += double(e.error[i][c]) * double(e.error[i][c]), total += double(e.mean[i][c]);
    const double n = 3.0 * double(e.mean.size());
    return variances == 0 ? 0 : std::sqrt(variances / n) / std::fabs(total / n);
}

}  // namespace

ReceiverIrradiance receiver_irradiance(const Receivers& receivers, const reference::PathScene& scene,
                                       const reference::PathParams& params, std::uint32_t seed, const RunOptions& options) {
    if (params.mode == reference::Mode::ambient_occlusion)
        throw InputError("receivers: ambient_occlusion is no irradiance: expected all, direct, one_bounce or indirect");
    if (receivers.count() == 0) throw InputError("receivers: there is none to trace");
    const glm::ivec2 grid = grid_of(receivers.count());
    const Image4 position = on_grid(receivers.position, grid), normal = on_grid(receivers.normal, grid);
    const reference::Estimate traced = reference::trace_irradiance(params, scene, {&position, &normal}, seed, options);
    ReceiverIrradiance e;
    e.mean.assign(traced.mean.texels.begin(), traced.mean.texels.begin() + receivers.count());
    e.error.assign(traced.error.texels.begin(), traced.error.texels.begin() + receivers.count());
    e.samples = traced.samples, e.rounds = traced.rounds, e.rays = traced.rays, e.nonfinite = traced.nonfinite;
    e.relative_error = relative_error(e);
    return e;
}

}  // namespace plumb::probes
