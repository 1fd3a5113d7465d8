#include <cmath>

#include "core/host_math.h"
#include "gi/isr/isr.h"

namespace plumb::isr {

namespace {

// What a white surface sends in the mean where lamps shine, W/(m2 sr): the luminance (17) of their irradiance over pi. In double and
// row by row, so that it is the same everywhere; it grows as lamps do, to the bit by powers of two.
float mean_light(const Image4& direct) {
    double sum = 0, lit = 0;
    for (const glm::vec4& e : direct.texels) {
        const double luminance = 0.27 * double(e.x) + 0.67 * double(e.y) + 0.06 * double(e.z);
        if (!(luminance > 0) || !std::isfinite(luminance)) continue;
        sum += luminance, lit += 1;
    }
    return lit > 0 ? float(sum / (host::pi * lit)) : 0;
}

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
    u.occlusion = u.published && params.ssao_term == SsaoTerm::occlusion;
    if (u.published) u.light_unit = params.light_unit > 0 ? params.light_unit : mean_light(bound("isr.compose", "direct", in.direct));
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
