#include "gi/compose/compose.h"

#include <fmt/format.h>

#include "core/error.h"
#include "core/fp_environment.h"
#include "core/host_math.h"
#include "core/parallel.h"
#include "gi/compose/bindings.h"
#include "gi/compose/compose_rows.h"

namespace plumb::compose {

namespace {

constexpr int band = 16;

ComposeInputsView view_of(const ComposeParams& params, const ComposeInputs& in) {
    ComposeInputsView v{};
    v.u = uniforms(params, in);
    v.normal = &in.normal->data()->x;
    v.albedo = &in.albedo->data()->x;
    v.emission = &in.emission->data()->x;
    v.direct = &in.direct->data()->x;
    v.indirect = &in.indirect->data()->x;
    return v;
}

TonemapInputsView view_of(const TonemapParams& params, const Image4& radiance) {
    return {uniforms(params, radiance), radiance.empty() ? nullptr : &radiance.data()->x, nullptr};
}

}  // namespace

ComposeUniforms uniforms(const ComposeParams& params, const ComposeInputs& in) {
    const glm::vec3 e = in.environment, c = params.shadow_color;
    return {{e.x, e.y, e.z, 0},     float(1 / host::pi),    in.normal->width,
            in.normal->height,      reads_density(params),  {c.x, c.y, c.z, 0}};
}

std::vector<Field> fields(ComposeParams& p) {
    return {
        {"shadow_color", &p.shadow_color, "W/(m2 sr)",
         "radiance of a surface without direct light (VRSM 4.3), by 1 - shadow density; black: left out", 0, 1e20, {},
         true},
    };
}

TonemapUniforms uniforms(const TonemapParams& params, const Image4& radiance) {
    return {int(params.op), params.exposure, radiance.width, radiance.height};
}

void validate(const ComposeInputs& in) {
    const std::pair<const char*, const Image4*> images[] = {{"normal", in.normal},
                                                            {"albedo", in.albedo},
                                                            {"emission", in.emission},
                                                            {"direct", in.direct},
                                                            {"indirect", in.indirect}};
    for (const auto& [name, image] : images) {
        if (!image) throw InputError(fmt::format("compose: {} must be bound", name));
        if (image->width != in.normal->width || image->height != in.normal->height)
            throw InputError(fmt::format("compose: {} is {} x {}, normal is {} x {}: expected equal sizes", name,
                                         image->width, image->height, in.normal->width, in.normal->height));
    }
}

void run(const ComposeParams& params, const ComposeInputs& in, const RunOptions& options, Image4& radiance) {
    ComposeParams copy = params;
    validate_fields("compose", fields(copy));
    validate(in);
    radiance = Image4(in.normal->width, in.normal->height);
    ComposeInputsView view = view_of(params, in);
    view.radiance = &radiance.data()->x;
    dispatch(options.isa, [&](auto isa) {
        parallel_bands(radiance.height, band, options,
                       [&](int first, int last) { Rows<isa()>::compose(view, first, last); });
    });
}

std::vector<TapValue> explain(const ComposeParams& params, const ComposeInputs& in, glm::ivec2 pixel) {
    validate(in);
    FpEnvironment environment;
    Recorder recorder;
    compose<float>(view_of(params, in), pixel.x, pixel.y, recorder);
    return recorder.values;
}

StageInfo compose_info() {
    ComposeParams defaults;
    StageInfo s;
    s.name = "compose";
    s.source = "VRSM 4.5 (direct light plus indirect light), 4.3 (shadow colour)";
    s.inputs = {{"normal", "image rgba32f", "", "w: 1 on a surface, 0 where nothing is"},
                {"albedo", "image rgba32f", "", "diffuse reflectance rho"},
                {"emission", "image rgba32f", "W/m2", "radiant exitance M"},
                {"direct", "image rgba32f", "W/m2", "direct irradiance; w: shadow density"},
                {"indirect", "image rgba32f", "W/m2", "indirect irradiance"}};
    s.outputs = {{"radiance", "image rgba32f", "W/(m2 sr)", "outgoing radiance towards the viewer"}};
    s.params = describe(fields(defaults));
    s.twin = "gi/compose/compose.comp";
    return s;
}

std::vector<Field> fields(TonemapParams& p) {
    return {
        {"operator", as_int(p.op), "", "the tone curve", 0, 3, {"clamp", "exposure", "reinhard", "filmic"}, true},
        {"exposure", &p.exposure, "m2 sr/W", "radiance is multiplied by it", 0, 1e20, {}, true},
    };
}

void run(const TonemapParams& params, const Image4& radiance, const RunOptions& options, Image4& display) {
    TonemapParams copy = params;
    validate_fields("tonemap", fields(copy));
    display = Image4(radiance.width, radiance.height);
    TonemapInputsView view = view_of(params, radiance);
    view.display = display.empty() ? nullptr : &display.data()->x;
    dispatch(options.isa, [&](auto isa) {
        parallel_bands(display.height, band, options,
                       [&](int first, int last) { Rows<isa()>::tonemap(view, first, last); });
    });
}

std::vector<TapValue> explain(const TonemapParams& params, const Image4& radiance, glm::ivec2 pixel) {
    FpEnvironment environment;
    Recorder recorder;
    tonemap<float>(view_of(params, radiance), pixel.x, pixel.y, recorder);
    return recorder.values;
}

StageInfo tonemap_info() {
    TonemapParams defaults;
    StageInfo s;
    s.name = "tonemap";
    s.source = "IPR 3.3 (exposure, Reinhard, filmic); IEC 61966-2-1";
    s.inputs = {{"radiance", "image rgba32f", "W/(m2 sr)", "outgoing radiance"}};
    s.outputs = {{"display", "image rgba32f", "", "sRGB-encoded, 0..1"}};
    s.params = describe(fields(defaults));
    s.twin = "gi/compose/tonemap.comp";
    return s;
}

std::vector<unsigned char> to_bytes(const Image4& display) {
    std::vector<unsigned char> bytes;
    bytes.reserve(display.size() * 3);
    for (const glm::vec4& pixel : display.texels)
        for (int c = 0; c < 3; ++c) bytes.push_back((unsigned char)number<float>::round_to_index(255.0f * pixel[c]));
    return bytes;
}

}  // namespace plumb::compose
