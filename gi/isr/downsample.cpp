#include <fmt/format.h>

#include <cmath>

#include "core/error.h"
#include "core/fp_environment.h"
#include "core/parallel.h"
#include "gi/isr/gather_inputs.h"

namespace plumb::isr {

namespace {

constexpr int band = 16;  // rows
constexpr const char* stage = "isr.downsample";

const float* texels_of(const Image4* image) { return image ? &image->data()->x : nullptr; }

DownsampleInputsView view_of(const IsrParams& params, Coarse what, const DownsampleInputs& in) {
    return {uniforms(params, what, in), texels_of(in.position), texels_of(in.normal), texels_of(in.albedo),
            texels_of(in.emission),     texels_of(in.direct),   nullptr};
}

// Of slope + offset / z, canonical clip depth. 0 where no plane is given, which no variant then reads.
struct DepthMap {
    float slope = 0, offset = 0;
};
DepthMap clip_depth_of(const DownsampleInputs& in) {
    if (!(in.near > 0)) return {};
    const double slope = std::isinf(in.far) ? 1 : in.far / (in.far - in.near);
    return {float(slope), float(-in.near * slope)};
}

}  // namespace

void validate(const IsrParams& params, Coarse what, const DownsampleInputs& in) {
    validate(params);
    const bool surface = what == Coarse::surface, published = params.variant == Variant::published;
    const bool lit = what == Coarse::radiosity && !published;
    if (!in.normal) throw InputError(fmt::format("{}: normal must be bound", stage));
    const std::pair<const char*, const Image4*> images[] = {
        {"position", in.position}, {"albedo", in.albedo}, {"emission", in.emission}, {"direct", in.direct}};
    const bool read[] = {surface, !surface, lit, lit};
    for (int i = 0; i < 4; ++i) {
        const auto& [name, image] = images[i];
        if (!read[i]) continue;
        if (!image) throw InputError(fmt::format("{}: {} must be bound", stage, name));
        if (image->width != in.normal->width || image->height != in.normal->height)
            throw InputError(fmt::format("{}: {} is {} x {}: expected {} x {}, as normal", stage, name, image->width,
                                         image->height, in.normal->width, in.normal->height));
    }
    if (surface && params.position == Position::inverse_matrix && !(in.near > 0 && in.far > in.near))
        throw InputError(fmt::format("{}: near = {}, far = {}: expected 0 < near < far, which position = inverse_matrix "
                                     "reads", stage, in.near, in.far));
    if (in.tiles && !in.tiles->fits(coarse_size({in.normal->width, in.normal->height})))
        throw InputError(fmt::format("{}: tiles are of another size", stage));
}

DownsampleUniforms uniforms(const IsrParams& params, Coarse what, const DownsampleInputs& in) {
    const glm::ivec2 full(in.normal->width, in.normal->height), coarse = coarse_size(full);
    const DepthMap depth = clip_depth_of(in);
    return {coarse.x, coarse.y, full.x, full.y, int(what), params.variant == Variant::published,
            params.position == Position::inverse_matrix, depth.slope, depth.offset, {}};
}

void run_downsample(const IsrParams& params, Coarse what, const DownsampleInputs& in, const RunOptions& options,
                    Image4& coarse) {
    validate(params, what, in);
    DownsampleInputsView view = view_of(params, what, in);
    Image4 result(view.u.width, view.u.height);
    view.coarse = &result.data()->x;
    const Tiles tiles = in.tiles ? Tiles{in.tiles->any.data(), in.tiles->tiles.x} : Tiles{};
    dispatch(options.isa, [&](auto isa) {
        parallel_bands(result.height, band, options,
                       [&](int first, int last) { GatherRows<isa()>::downsample(view, first, last, tiles); });
    });
    coarse = std::move(result);
}

std::vector<TapValue> explain_downsample(const IsrParams& params, Coarse what, const DownsampleInputs& in,
                                         glm::ivec2 pixel) {
    validate(params, what, in);
    FpEnvironment environment;
    Recorder recorder;
    downsample<float>(view_of(params, what, in), pixel.x, pixel.y, recorder);
    return recorder.values;
}

StageInfo info_downsample() {
    IsrParams defaults;
    StageInfo s;
    s.name = "isr.downsample";
    s.source = "ISR 4.2, Listing 3: buffers of a quarter of the pixels";
    s.inputs = {{"position", "image rgba32f", "m", "w: linear eye depth"},
                {"normal", "image rgba32f", "", "unit normal, w 1"},
                {"albedo", "image rgba32f", "", "w: radiation mask"},
                {"emission", "image rgba32f", "W/m2", "radiant exitance"},
                {"direct", "image rgba32f", "W/m2", "direct irradiance"}};
    s.outputs = {{"coarse", "image rgba32f", "", "surface, radiosity or reflectance"}};
    for (const Field& f : fields(defaults))
        if (f.name == "variant" || f.name == "position") s.params.push_back(describe({f}).front());
    s.twin = "gi/isr/downsample.comp";
    return s;
}

}  // namespace plumb::isr
