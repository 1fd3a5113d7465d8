#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"
#include "core/fp_environment.h"
#include "core/host_math.h"
#include "core/parallel.h"
#include "gi/isr/bindings_filter.h"
#include "gi/isr/blur_rows.h"

namespace plumb::isr {

namespace {

constexpr int band = 32;  // rows: a vertical blur also reads the rows around them

int radius_of(const IsrParams& params) { return params.blur == Blur::none ? 0 : params.blur_radius; }

BlurKind kind_of(const IsrParams& params) {
    if (params.blur == Blur::edge_aware) return BlurKind::edge_aware;
    return params.variant == Variant::published && params.blur == Blur::gaussian ? BlurKind::published
                                                                                 : BlurKind::gaussian;
}

BlurInputsView view_of(const IsrParams& params, const BlurInputs& in, const Buffer<float>& spatial) {
    return {uniforms(params, in), &in.lit->data()->x, &in.surface->data()->x, spatial.data(), nullptr};
}

}  // namespace

void check_images(const char* stage, std::initializer_list<NamedImage> images, glm::ivec2 size, const char* why) {
    for (const auto& [name, image] : images) {
        if (!image) throw InputError(fmt::format("{}: {} must be bound", stage, name));
        if (image->width != size.x || image->height != size.y)
            throw InputError(fmt::format("{}: {} is {} x {}: expected {} x {}, {}", stage, name, image->width,
                                         image->height, size.x, size.y, why));
        if (image->empty()) throw InputError(fmt::format("{}: {} is empty: expected at least 1 x 1", stage, name));
    }
}

void resize(Image4& image, glm::ivec2 size, bool fill, glm::vec4 value) {
    if (image.width != size.x || image.height != size.y)
        image = Image4(size.x, size.y, value);
    else if (fill)
        std::fill(image.texels.begin(), image.texels.end(), value);
}

Buffer<float> blur_weights(const IsrParams& params) {
    const int radius = radius_of(params);
    const double sigma = params.blur_sigma;
    std::vector<double> g;
    double total = 0;
    for (int d = -radius; d <= radius; ++d) total += g.emplace_back(host::exp(-(d * d) / (2 * sigma * sigma)));
    Buffer<float> weights;
    for (double w : g) weights.push_back(float(w / total));
    return weights;
}

BlurUniforms uniforms(const IsrParams& params, const BlurInputs& in) {
    const bool vertical = in.direction == Direction::vertical;
    return {in.lit->width, in.lit->height, radius_of(params), vertical, int(kind_of(params)), {}};
}

void validate(const IsrParams& params, const BlurInputs& in) {
    const char* stage = "isr.blur";
    validate(params);
    if (!in.lit) throw InputError(fmt::format("{}: lit must be bound", stage));
    const glm::ivec2 size{in.lit->width, in.lit->height};
    check_images(stage, {{"lit", in.lit}, {"surface", in.surface}}, size, "as lit");
    if (in.tiles && !in.tiles->fits(size)) throw InputError(fmt::format("{}: tiles are of another size", stage));
}

void run(const IsrParams& params, const BlurInputs& in, const RunOptions& options, Image4& blurred) {
    validate(params, in);
    const Buffer<float> spatial = blur_weights(params);
    // Where tiles say so, what has no surface is not computed: nothing, and open. As printed it is blurred too.
    const bool skips = in.tiles && kind_of(params) != BlurKind::published;
    const bool in_place = &blurred == in.lit || &blurred == in.surface;
    Image4 other;
    Image4& result = in_place ? other : blurred;
    resize(result, {in.lit->width, in.lit->height}, skips, {0, 0, 0, 1});
    BlurInputsView view = view_of(params, in, spatial);
    view.blurred = &result.data()->x;
    const Tiles tiles = skips ? Tiles{in.tiles->any.data(), in.tiles->tiles.x} : Tiles{};
    dispatch(options.isa, [&](auto isa) {
        parallel_bands(result.height, band, options, [&](int first, int last) {
            Buffer<float> planes(BlurPlanes::floats(view.u, last - first));
            BlurRows<isa()>::blur(view, first, last, planes.data(), tiles);
        });
    });
    if (in_place) blurred = std::move(other);
}

std::vector<TapValue> explain(const IsrParams& params, const BlurInputs& in, glm::ivec2 pixel) {
    validate(params, in);
    const Buffer<float> spatial = blur_weights(params);
    const BlurInputsView view = view_of(params, in, spatial);
    FpEnvironment environment;
    Recorder recorder;
    blur<float>(view.u, view.spatial, BlurImageTexels<float>{view, pixel.x, pixel.y}, recorder);
    return recorder.values;
}

StageInfo info_blur() {
    IsrParams defaults;
    StageInfo s;
    s.name = "isr.blur";
    s.source = "ISR 4.2, Listing 3 (Gaussian blur of the coarse result, horizontal and vertical)";
    s.inputs = {{"lit", "image rgba32f", "W/m2", "irradiance; w: accessibility"},
                {"surface", "image rgba32f", "", "unit normal; w: linear eye depth, m"},
                {"spatial", "buffer f32", "", "Gaussian of the distance"}};
    s.outputs = {{"blurred", "image rgba32f", "W/m2", "irradiance; w: accessibility"}};
    for (const Field& f : fields(defaults))
        if (f.name == "variant" || f.name == "blur" || f.name == "blur_radius" || f.name == "blur_sigma")
            s.params.push_back(describe({f}).front());
    s.twin = "gi/isr/blur.comp";
    return s;
}

}  // namespace plumb::isr
