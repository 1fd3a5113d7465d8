#include <cmath>

#include "gi/isr/isr.h"

namespace plumb::isr {

namespace {

bool bilateral(const IsrParams& params) { return params.upsample == Upsample::bilateral; }
bool published(const IsrParams& params) { return params.variant == Variant::published; }

void check_planes(const IsrParams& params, const UpsampleInputs& in) {
    const char* stage = "isr.upsample";
    if (!bilateral(params)) return;
    if (params.position == Position::inverse_matrix && !(in.near > 0 && in.far > in.near))
        throw InputError(fmt::format("{}: near = {}, far = {}: expected 0 < near < far", stage, in.near, in.far));
    if (published(params) && !(in.far > 0 && std::isfinite(in.far)))
        throw InputError(fmt::format("{}: far = {}: expected a finite far plane above 0 m, since variant = published "
                                     "compares depths as shares of it (ISR (27))", stage, in.far));
}

UpsampleUniforms uniforms(const IsrParams& params, const UpsampleInputs& in) {
    const bool clip = bilateral(params) && params.position == Position::inverse_matrix;
    const bool by_far = bilateral(params) && published(params);
    UpsampleUniforms u{};
    u.width = in.position->width, u.height = in.position->height;
    u.coarse_width = in.lit->width, u.coarse_height = in.lit->height;
    u.bilateral = bilateral(params), u.published = published(params), u.clip_depth = clip;
    u.epsilon = params.epsilon;
    u.far = by_far ? float(in.far) : 1;
    u.per_near = clip ? float(1 / in.near) : 0;
    u.per_far_less_near = clip ? float(1 / in.far - 1 / in.near) : 0;
    return u;
}

}  // namespace

StageData data_of(const IsrParams& params, const UpsampleInputs& in) {
    validate(params);
    check_planes(params, in);
    bound("isr.upsample", "lit", in.lit);
    const glm::ivec2 size = size_of(bound("isr.upsample", "position", in.position));
    StageData d = begin_data<UpsampleKernel>(size, uniforms(params, in));
    lend(d, {{"lit", in.lit}, {"surface", in.surface}, {"position", in.position}, {"normal", in.normal}});
    lend_tiles(d, in.tiles);
    return d;
}

}  // namespace plumb::isr
