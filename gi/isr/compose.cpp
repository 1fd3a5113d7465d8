#include "core/host_math.h"
#include "gi/isr/isr.h"

namespace plumb::isr {

namespace {

ComposeUniforms uniforms(const IsrParams& params, const ComposeInputs& in) {
    ComposeUniforms u{};
    const bool ambient = params.variant == Variant::corrected && params.ambient == Ambient::environment;
    for (int c = 0; c < 3; ++c) {
        u.environment[c] = in.environment[c];
        u.ambient[c] = ambient ? float(host::pi * double(in.environment[c])) : 0;
    }
    u.inv_pi = float(1 / host::pi);
    u.k_ssao = params.k_ssao, u.k_isr = params.k_isr;
    u.published = params.variant == Variant::published;
    u.width = in.normal->width, u.height = in.normal->height;
    return u;
}

}  // namespace

StageData data_of(const IsrParams& params, const ComposeInputs& in) {
    validate(params);
    const glm::ivec2 size = size_of(bound("isr.compose", "normal", in.normal));
    StageData d = begin_data<ComposeKernel>(size, uniforms(params, in));
    lend(d, {{"normal", in.normal}, {"albedo", in.albedo}, {"emission", in.emission}, {"direct", in.direct},
             {"indirect", in.indirect}});
    return d;
}

}  // namespace plumb::isr
