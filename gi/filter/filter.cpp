#include "gi/filter/filter.h"

#include "core/host_math.h"

namespace plumb::filter {

namespace {

void check_params(const char* stage, const FilterParams& params) {
    FilterParams copy = params;
    validate_fields(stage, fields(copy));
    if (params.kernel % 2 == 0) throw InputError(fmt::format("{}: kernel = {}: expected an odd number", stage, params.kernel));
}

float normal_slope(const FilterParams& params) { return 1 / params.sigma_normal; }
float normal_offset(const FilterParams& params) { return 1 - 1 / params.sigma_normal; }

}  // namespace

std::vector<Field> fields(FilterParams& p) {
    return {
        {"resolution", as_int(p.resolution), "", "of the indirect light: every pixel, or one of 2 x 2 (VRSM 4.4)", 0, 1,
         {"full", "half"}, false},
        {"upsample", as_int(p.upsample), "",
         "how half resolution becomes full: bilinear weights times depth and normal (ours), bilinear alone, or bilinear "
         "as a GPU places pixels (published, VRSM 4.5)", 0, 2, {"bilateral", "bilinear", "published"}, true},
        {"blur", as_int(p.blur), "", "edge-aware blur of the indirect light (VRSM 4.5): all of the kernel, or a row and "
         "then a column of it; automatic: separable after gathers that sample a map (disc, paths) where no frames share light, "
         "else none", 0, 3, {"automatic", "none", "full", "separable"}, false},
        {"kernel", &p.kernel, "pixels", "side of the blur, odd; 17 is VRSM 4.5's", 1, 33, {}, false},
        {"sigma_distance", &p.sigma_distance, "pixels", "of the Gaussian within the kernel; ours", 1e-3, 1e6, {}, false},
        {"similarity", as_int(p.similarity), "",
         "what depth difference means: distance from the plane of the pixel (ours), or of depths (VRSM 4.5)", 0, 1,
         {"plane", "depth"}, true},
        {"sigma_depth", &p.sigma_depth, "depths", "where depth similarity ends, as a share of the depth; ours", 1e-6, 1e6,
         {}, true},
        {"sigma_normal", &p.sigma_normal, "", "where normal continuity ends: 1 - cosine; ours", 1e-4, 1, {}, true},
    };
}

Buffer<float> spatial_weights(const FilterParams& params, Direction direction) {
    const int radius = params.kernel / 2;
    const int rx = direction == Direction::vertical ? 0 : radius, ry = direction == Direction::horizontal ? 0 : radius;
    const double sigma = params.sigma_distance;
    Buffer<float> weights;
    for (int dy = -ry; dy <= ry; ++dy)
        for (int dx = -rx; dx <= rx; ++dx)
            weights.push_back(dx == 0 && dy == 0 ? 0 : float(host::exp(-(dx * dx + dy * dy) / (2 * sigma * sigma))));
    return weights;
}

std::vector<ParamInfo> params_of(const std::vector<std::string>& names) {
    FilterParams defaults;
    return describe(fields(defaults), names);
}

std::string refuse_half(glm::ivec2 full, glm::ivec2 half) {
    if (half_size(full) == half) return "";
    return fmt::format("{} x {} of {} x {}: expected half of it, rounded up", half.x, half.y, full.x, full.y);
}

StageData data_of(const FilterParams&, const ReduceInputs& in) {
    const glm::ivec2 full = size_of(bound("filter.reduce", "full", in.full)), half = half_size(full);
    StageData d = begin_data<ReduceKernel>(half, ReduceUniforms{half.x, half.y, full.x, full.y});
    lend(d, {{"full", in.full}});
    return d;
}

StageData data_of(const FilterParams& p, const UpsampleInputs& in) {
    check_params("filter.upsample", p);
    const glm::ivec2 size = size_of(bound("filter.upsample", "position", in.position)), half = half_size(size);
    StageData d = begin_data<UpsampleKernel>(
        size, UpsampleUniforms{size.x, size.y, half.x, half.y, int(p.upsample), int(p.similarity), p.sigma_depth,
                               normal_slope(p), normal_offset(p), {}});
    lend(d, {{"coarse_irradiance", in.coarse_irradiance}, {"coarse_position", in.coarse_position},
             {"coarse_normal", in.coarse_normal}, {"position", in.position}, {"normal", in.normal}});
    lend_tiles(d, in.tiles);
    return d;
}

StageData data_of(const FilterParams& p, const BlurInputs& in) {
    check_params("filter.blur", p);
    const glm::ivec2 size = size_of(bound("filter.blur", "irradiance", in.irradiance));
    const int across = in.direction == Direction::vertical ? 0 : p.kernel / 2;
    const int down = in.direction == Direction::horizontal ? 0 : p.kernel / 2;
    StageData d = begin_data<BlurKernel>(size, BlurUniforms{size.x, size.y, across, down, int(p.similarity), p.sigma_depth,
                                                            normal_slope(p), normal_offset(p)});
    lend(d, {{"irradiance", in.irradiance}, {"position", in.position}, {"normal", in.normal}});
    const Buffer<float> spatial = spatial_weights(p, in.direction);
    add(d.inputs, "spatial", {int(spatial.size())}, spatial.data());
    lend_tiles(d, in.tiles);
    return d;
}

void run_blur(const FilterParams& params, const BlurInputs& in, const RunOptions& options, Image4& blurred) {
    BlurInputs one = in;
    if (params.blur == Blur::none) {
        check_params("filter.blur", params);
        blurred = bound("filter.blur", "irradiance", in.irradiance);
    } else if (params.blur == Blur::full) {
        one.direction = Direction::both;
        run(params, one, options, blurred);
    } else {
        Image4 across;
        one.direction = Direction::horizontal;
        run(params, one, options, across);
        one.direction = Direction::vertical, one.irradiance = &across;
        run(params, one, options, blurred);
    }
}

}  // namespace plumb::filter
