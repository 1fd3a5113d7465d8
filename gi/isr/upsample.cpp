#include <fmt/format.h>

#include <cmath>

#include "core/error.h"
#include "core/fp_environment.h"
#include "core/parallel.h"
#include "gi/isr/bindings_filter.h"
#include "gi/isr/upsample_rows.h"

namespace plumb::isr {

namespace {

constexpr int band = 16;  // rows

bool bilateral(const IsrParams& params) { return params.upsample == Upsample::bilateral; }
bool published(const IsrParams& params) { return params.variant == Variant::published; }

UpsampleInputsView view_of(const IsrParams& params, const UpsampleInputs& in) {
    return {uniforms(params, in),     &in.lit->data()->x,    &in.surface->data()->x,
            &in.position->data()->x, &in.normal->data()->x, nullptr};
}

}  // namespace

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

void validate(const IsrParams& params, const UpsampleInputs& in) {
    const char* stage = "isr.upsample";
    validate(params);
    if (!in.position) throw InputError(fmt::format("{}: position must be bound", stage));
    const glm::ivec2 size{in.position->width, in.position->height};
    check_images(stage, {{"position", in.position}, {"normal", in.normal}}, size, "as position");
    check_images(stage, {{"lit", in.lit}, {"surface", in.surface}}, coarse_size(size), "half of position, rounded up");
    if (in.tiles && !in.tiles->fits(size)) throw InputError(fmt::format("{}: tiles are of another size", stage));
    if (!bilateral(params)) return;
    if (params.position == Position::inverse_matrix && !(in.near > 0 && in.far > in.near))
        throw InputError(fmt::format("{}: near = {}, far = {}: expected 0 < near < far", stage, in.near, in.far));
    if (published(params) && !(in.far > 0 && std::isfinite(in.far)))
        throw InputError(fmt::format("{}: far = {}: expected a finite far plane above 0 m, since variant = published "
                                     "compares depths as shares of it (ISR (27))", stage, in.far));
}

void run(const IsrParams& params, const UpsampleInputs& in, const RunOptions& options, Image4& upsampled) {
    validate(params, in);
    const bool in_place = &upsampled == in.lit || &upsampled == in.surface;
    Image4 other;
    Image4& result = in_place ? other : upsampled;
    resize(result, {in.position->width, in.position->height}, in.tiles != nullptr, {0, 0, 0, 1});
    UpsampleInputsView view = view_of(params, in);
    view.upsampled = &result.data()->x;
    const Tiles tiles = in.tiles ? Tiles{in.tiles->any.data(), in.tiles->tiles.x} : Tiles{};
    dispatch(options.isa, [&](auto isa) {
        parallel_bands(result.height, band, options, [&](int first, int last) {
            Buffer<float> planes(UpsamplePlanes::floats(result.width, last - first));
            UpsampleRows<isa()>::upsample(view, first, last, planes.data(), tiles);
        });
    });
    if (in_place) upsampled = std::move(other);
}

std::vector<TapValue> explain(const IsrParams& params, const UpsampleInputs& in, glm::ivec2 pixel) {
    validate(params, in);
    const UpsampleInputsView view = view_of(params, in);
    FpEnvironment environment;
    Recorder recorder;
    upsample<float>(view, UpsampleImageTexels<float>{view, pixel.x, pixel.y}, pixel.x, pixel.y, recorder);
    return recorder.values;
}

StageInfo info_upsample() {
    IsrParams defaults;
    StageInfo s;
    s.name = "isr.upsample";
    s.source = "ISR 4.5, (27), (28)";
    s.inputs = {{"lit", "image rgba32f", "W/m2", "coarse irradiance; w: accessibility"},
                {"surface", "image rgba32f", "", "coarse unit normal; w: depth"},
                {"position", "image rgba32f", "m", "w: linear eye depth"},
                {"normal", "image rgba32f", "", "unit normal"}};
    s.outputs = {{"upsampled", "image rgba32f", "W/m2", "irradiance of every pixel; w: accessibility"}};
    for (const Field& f : fields(defaults))
        if (f.name == "variant" || f.name == "position" || f.name == "upsample" || f.name == "epsilon")
            s.params.push_back(describe({f}).front());
    s.twin = "gi/isr/upsample.comp";
    return s;
}

}  // namespace plumb::isr
