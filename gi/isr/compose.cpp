#include <fmt/format.h>

#include "core/error.h"
#include "core/fp_environment.h"
#include "core/host_math.h"
#include "core/parallel.h"
#include "gi/isr/bindings_filter.h"
#include "gi/isr/compose_rows.h"

namespace plumb::isr {

namespace {

constexpr int band = 16;  // rows

ComposeInputsView view_of(const IsrParams& params, const ComposeInputs& in) {
    return {uniforms(params, in),     &in.normal->data()->x, &in.albedo->data()->x,
            &in.emission->data()->x, &in.direct->data()->x, &in.indirect->data()->x,
            nullptr};
}

}  // namespace

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

void validate(const IsrParams& params, const ComposeInputs& in) {
    const char* stage = "isr.compose";
    validate(params);
    if (!in.normal) throw InputError(fmt::format("{}: normal must be bound", stage));
    const glm::ivec2 size{in.normal->width, in.normal->height};
    check_images(stage, {{"normal", in.normal}, {"albedo", in.albedo}, {"emission", in.emission}, {"direct", in.direct},
                         {"indirect", in.indirect}}, size, "as normal");
}

void run(const IsrParams& params, const ComposeInputs& in, const RunOptions& options, Image4& radiance) {
    validate(params, in);
    // A pixel is read before it is written: an input may be composed over.
    resize(radiance, {in.normal->width, in.normal->height}, false, glm::vec4(0));
    ComposeInputsView view = view_of(params, in);
    view.radiance = &radiance.data()->x;
    dispatch(options.isa, [&](auto isa) {
        parallel_bands(radiance.height, band, options,
                       [&](int first, int last) { ComposeRows<isa()>::compose(view, first, last); });
    });
}

std::vector<TapValue> explain(const IsrParams& params, const ComposeInputs& in, glm::ivec2 pixel) {
    validate(params, in);
    FpEnvironment environment;
    Recorder recorder;
    compose<float>(view_of(params, in), pixel.x, pixel.y, recorder);
    return recorder.values;
}

StageInfo info_compose() {
    IsrParams defaults;
    StageInfo s;
    s.name = "isr.compose";
    s.source = "ISR 4.5, (29)";
    s.inputs = {{"normal", "image rgba32f", "", "w: 1 on a surface, 0 where nothing is"},
                {"albedo", "image rgba32f", "", "diffuse reflectance rho"},
                {"emission", "image rgba32f", "W/m2", "radiant exitance M"},
                {"direct", "image rgba32f", "W/m2", "direct irradiance"},
                {"indirect", "image rgba32f", "W/m2", "indirect irradiance; w: accessibility"}};
    s.outputs = {{"radiance", "image rgba32f", "W/(m2 sr)", "outgoing radiance towards the viewer"}};
    for (const Field& f : fields(defaults))
        if (f.name == "variant" || f.name == "k_ssao" || f.name == "k_isr" || f.name == "ambient")
            s.params.push_back(describe({f}).front());
    s.twin = "gi/isr/compose.comp";
    return s;
}

}  // namespace plumb::isr
