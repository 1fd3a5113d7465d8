#include "gi/direct/visibility_filter.h"

#include <algorithm>

#include "gi/filter/filter.h"

namespace plumb::direct {

namespace {

Buffer<float> weights_of(const ShadowParams& params) {
    filter::FilterParams of;
    of.kernel = 2 * params.filter_radius + 1, of.sigma_distance = params.filter_sigma;
    return filter::spatial_weights(of, filter::Direction::horizontal);
}

}  // namespace

StageData data_of(const ShadowParams& params, const VisibilityFilterInputs& in) {
    ShadowParams copy = params;
    validate_fields(visibility_filter_stage, fields(copy));
    const glm::ivec2 size = size_of(bound(visibility_filter_stage, "normal", in.normal));
    if (!in.visibility) throw InputError(fmt::format("{}: visibility must be bound", visibility_filter_stage));
    if (params.filter == VisibilityFilter::none) throw InputError(fmt::format("{}: filter is none", visibility_filter_stage));
    const bool edges = params.filter == VisibilityFilter::edge_aware;
    const float slope = 1 / params.filter_sigma_normal;
    StageData d = begin_data<VisibilityFilterKernel>(
        size, VisibilityFilterUniforms{size.x, size.y, params.filter_radius, in.direction == Direction::vertical ? 1 : 0,
                                       int(edges ? FilterKind::edge_aware : FilterKind::gaussian), params.filter_sigma_depth,
                                       slope, 1 - slope});
    lend(d.inputs, "visibility", {size.y, size.x}, in.visibility);
    lend(d, {{"position", in.position}, {"normal", in.normal}});
    const Buffer<float> spatial = weights_of(params);
    add(d.inputs, "spatial", {int(spatial.size())}, spatial.data());
    return d;
}

void filter_visibility(const ShadowParams& params, const VisibilityFilterInputs& in, const RunOptions& options, float* filtered) {
    const std::size_t pixels = bound(visibility_filter_stage, "normal", in.normal).size();
    if (params.filter == VisibilityFilter::none) {
        std::copy_n(in.visibility, pixels, filtered);
        return;
    }
    Buffer<float> across(pixels);
    VisibilityFilterInputs pass = in;
    pass.direction = Direction::horizontal;
    run(stage<VisibilityFilterKernel>(), data_of(params, pass), options, across.data());
    pass.direction = Direction::vertical, pass.visibility = across.data();
    run(stage<VisibilityFilterKernel>(), data_of(params, pass), options, filtered);
}

}  // namespace plumb::direct
