#include "gi/compose/compose.h"

#include <fmt/format.h>

#include "core/error.h"
#include "core/host_math.h"

namespace plumb::compose {

std::vector<Field> fields(ComposeParams& p) {
    return {
        {"shadow_color", &p.shadow_color, "W/(m2 sr)",
         "radiance of a surface without direct light (VRSM 4.3), by 1 - shadow density; black: left out", 0, 1e20, {},
         true},
    };
}

StageData data_of(const ComposeParams& params, const ComposeInputs& in) {
    ComposeParams copy = params;
    validate_fields("compose", fields(copy));
    const glm::ivec2 size = size_of(bound("compose", "normal", in.normal));
    const glm::vec3 e = in.environment, c = params.shadow_color;
    StageData d = begin_data<ComposeKernel>(size, ComposeUniforms{{e.x, e.y, e.z, 0}, float(1 / host::pi), size.x, size.y,
                                                                  reads_density(params), {c.x, c.y, c.z, 0}});
    lend(d, {{"normal", in.normal}, {"albedo", in.albedo}, {"emission", in.emission}, {"direct", in.direct},
             {"indirect", in.indirect}});
    return d;
}

std::vector<Field> fields(TonemapParams& p) {
    return {
        {"operator", as_int(p.op), "", "the tone curve", 0, 3, {"clamp", "exposure", "reinhard", "filmic"}, true},
        {"exposure", &p.exposure, "m2 sr/W", "radiance is multiplied by it", 0, 1e20, {}, true},
        {"dimmer", &p.dimmer, "", "dims all light before the curve (IPR figure A.1)", 0, 1, {}, true},
        {"contrast", &p.contrast, "", "a power about middle grey, 0.18, before the curve (IPR figure A.1)", 0.1, 10, {},
         true},
        {"gamma", &p.gamma, "", "encodes by its inverse as a power (IPR figure A.1); 0: the curve of sRGB", 0, 10, {},
         false},
    };
}

void validate(const TonemapParams& params) {
    TonemapParams copy = params;
    validate_fields("tonemap", fields(copy));
    if (params.gamma > 0 && params.gamma < 0.1f)
        throw InputError(fmt::format("tonemap: gamma = {}: expected 0 for the curve of sRGB, or 0.1 to 10", params.gamma));
}

StageData data_of(const TonemapParams& params, const TonemapInputs& in) {
    validate(params);
    const float inv_gamma = params.gamma > 0 ? float(1 / double(params.gamma)) : 0;
    const glm::ivec2 size = size_of(bound("tonemap", "radiance", in.radiance));
    StageData d = begin_data<TonemapKernel>(size, TonemapUniforms{int(params.op), params.exposure, size.x, size.y, params.dimmer,
                                                                   params.contrast, inv_gamma, 0});
    lend(d, {{"radiance", in.radiance}});
    return d;
}

std::vector<unsigned char> to_bytes(const Image4& display) {
    std::vector<unsigned char> bytes;
    bytes.reserve(display.size() * 3);
    for (const glm::vec4& pixel : display.texels)
        for (int c = 0; c < 3; ++c) bytes.push_back((unsigned char)number<float>::round_to_index(255.0f * pixel[c]));
    return bytes;
}

}  // namespace plumb::compose
