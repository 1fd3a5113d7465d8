#include <cmath>

#include "gi/isr/isr.h"

namespace plumb::isr {

namespace {

// Of slope + offset / z, canonical clip depth. 0 where no plane is given, which no variant then reads.
struct DepthMap {
    float slope = 0, offset = 0;
};
DepthMap clip_depth_of(const DownsampleInputs& in) {
    if (!(in.near > 0)) return {};
    const double slope = std::isinf(in.far) ? 1 : in.far / (in.far - in.near);
    return {float(slope), float(-in.near * slope)};
}

// What the kernel does not read may be a texel of nothing.
const Image4& or_nothing(bool read, const char* name, const Image4* image) {
    static const Image4 nothing(1, 1);
    return read ? bound("isr.downsample", name, image) : nothing;
}

}  // namespace

StageData data_of(const IsrParams& params, const DownsampleInputs& in) {
    const char* stage = "isr.downsample";
    validate(params);
    const bool surface = in.what == Coarse::surface, published = params.variant == Variant::published;
    const bool lit = in.what == Coarse::radiosity && !published;
    if (surface && params.position == Position::inverse_matrix && !(in.near > 0 && in.far > in.near))
        throw InputError(fmt::format("{}: near = {}, far = {}: expected 0 < near < far, which position = inverse_matrix "
                                     "reads", stage, in.near, in.far));
    const glm::ivec2 full = size_of(bound(stage, "normal", in.normal)), coarse = coarse_size(full, coarse_side(params));
    const DepthMap depth = clip_depth_of(in);
    StageData d = begin_data<DownsampleKernel>(
        coarse, DownsampleUniforms{coarse.x, coarse.y, full.x, full.y, int(in.what), published,
                                   params.position == Position::inverse_matrix, depth.slope, depth.offset,
                                   params.resolution == Resolution::native, {}});
    lend(d, {{"position", &or_nothing(surface, "position", in.position)},
             {"normal", in.normal},
             {"albedo", &or_nothing(!surface, "albedo", in.albedo)},
             {"emission", &or_nothing(lit, "emission", in.emission)},
             {"direct", &or_nothing(lit, "direct", in.direct)}});
    lend_tiles(d, in.tiles);
    return d;
}

}  // namespace plumb::isr
