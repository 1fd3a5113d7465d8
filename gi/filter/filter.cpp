#include "gi/filter/filter.h"

#include <fmt/format.h>

#include "core/error.h"
#include "core/fp_environment.h"
#include "core/host_math.h"
#include "core/parallel.h"
#include "gi/filter/bindings.h"
#include "gi/filter/filter_rows.h"
#include "gi/scratch.h"

namespace plumb::filter {

namespace {

constexpr int band = 16;        // rows of a band; of the blur 32, since each band reads the rows around it
constexpr int blur_band = 32;

void check_sizes(const char* stage, std::initializer_list<std::pair<const char*, const Image4*>> images,
                 glm::ivec2 size, const std::string& why) {
    for (const auto& [name, image] : images) {
        if (!image) throw InputError(fmt::format("{}: {} must be bound", stage, name));
        if (image->width != size.x || image->height != size.y)
            throw InputError(fmt::format("{}: {} is {} x {}: expected {} x {}, {}", stage, name, image->width,
                                         image->height, size.x, size.y, why));
    }
}

void check_params(const char* stage, const FilterParams& params) {
    FilterParams copy = params;
    validate_fields(stage, fields(copy));
    if (params.kernel % 2 == 0) throw InputError(fmt::format("{}: kernel = {}: expected an odd number", stage, params.kernel));
}

void check_tiles(const char* stage, const raster::Covered* tiles, glm::ivec2 size) {
    if (tiles && !tiles->fits(size)) throw InputError(fmt::format("{}: tiles are of another size", stage));
}

Tiles tiles_of(const raster::Covered* tiles) {
    return tiles ? Tiles{tiles->any.data(), tiles->tiles.x} : Tiles{};
}

float normal_slope(const FilterParams& params) { return 1 / params.sigma_normal; }
float normal_offset(const FilterParams& params) { return 1 - 1 / params.sigma_normal; }

ReduceInputsView view_of(const Image4& image) { return {uniforms(image), &image.data()->x, nullptr}; }

UpsampleInputsView view_of(const FilterParams& params, const UpsampleInputs& in) {
    return {uniforms(params, in),         &in.coarse_irradiance->data()->x, &in.coarse_position->data()->x,
            &in.coarse_normal->data()->x, &in.position->data()->x,   &in.normal->data()->x,
            nullptr};
}

BlurInputsView view_of(const FilterParams& params, const BlurInputs& in, const Buffer<float>& spatial) {
    return {uniforms(params, in),   &in.irradiance->data()->x, &in.position->data()->x,
            &in.normal->data()->x, spatial.data(),            nullptr};
}

}  // namespace

std::vector<Field> fields(FilterParams& p) {
    return {
        {"resolution", as_int(p.resolution), "", "of the indirect light: every pixel, or one of 2 x 2 (VRSM 4.4)", 0, 1,
         {"full", "half"}, false},
        {"upsample", as_int(p.upsample), "",
         "how half resolution becomes full: bilinear weights times depth and normal (ours), bilinear alone, or bilinear "
         "as a GPU places pixels (published, VRSM 4.5)", 0, 2, {"bilateral", "bilinear", "published"}, true},
        {"blur", as_int(p.blur), "", "edge-aware blur of the indirect light (VRSM 4.5): all of the kernel, or a row and "
         "then a column of it", 0, 2, {"none", "full", "separable"}, false},
        {"kernel", &p.kernel, "pixels", "side of the blur, odd; 17 is VRSM 4.5's", 1, 33, {}, false},
        {"sigma_distance", &p.sigma_distance, "pixels", "of the Gaussian within the kernel; ours", 1e-3, 1e6, {}, false},
        {"similarity", as_int(p.similarity), "",
         "what depth difference means: distance from the plane of the pixel (ours), or of depths (VRSM 4.5)", 0, 1,
         {"plane", "depth"}, true},
        {"sigma_depth", &p.sigma_depth, "depths", "where depth similarity ends, as a share of the depth; ours", 1e-6, 1e6,
         {}, true},
        {"sigma_normal", &p.sigma_normal, "", "where normal continuity ends: 1 - cosine; ours", 1e-4, 1, {}, true},
    };
}

Buffer<float> spatial_weights(const FilterParams& params, Direction direction) {
    const int radius = params.kernel / 2;
    const int rx = direction == Direction::vertical ? 0 : radius, ry = direction == Direction::horizontal ? 0 : radius;
    const double sigma = params.sigma_distance;
    Buffer<float> weights;
    for (int dy = -ry; dy <= ry; ++dy)
        for (int dx = -rx; dx <= rx; ++dx)
            weights.push_back(dx == 0 && dy == 0 ? 0 : float(host::exp(-(dx * dx + dy * dy) / (2 * sigma * sigma))));
    return weights;
}

ReduceUniforms uniforms(const Image4& image) {
    const glm::ivec2 size = half_size({image.width, image.height});
    return {size.x, size.y, image.width, image.height};
}

UpsampleUniforms uniforms(const FilterParams& params, const UpsampleInputs& in) {
    return {in.position->width,   in.position->height,    in.coarse_irradiance->width, in.coarse_irradiance->height,
            int(params.upsample), int(params.similarity), params.sigma_depth,   normal_slope(params),
            normal_offset(params), {}};
}

BlurUniforms uniforms(const FilterParams& params, const BlurInputs& in) {
    const int radius = params.kernel / 2;
    return {in.irradiance->width,
            in.irradiance->height,
            in.direction == Direction::vertical ? 0 : radius,
            in.direction == Direction::horizontal ? 0 : radius,
            int(params.similarity),
            params.sigma_depth,
            normal_slope(params),
            normal_offset(params)};
}

void validate(const FilterParams& params, const UpsampleInputs& in) {
    const char* stage = "filter.upsample";
    check_params(stage, params);
    if (!in.position) throw InputError(std::string(stage) + ": position must be bound");
    const glm::ivec2 size{in.position->width, in.position->height};
    check_sizes(stage, {{"normal", in.normal}}, size, "as position");
    check_sizes(stage, {{"coarse_irradiance", in.coarse_irradiance}, {"coarse_position", in.coarse_position},
                        {"coarse_normal", in.coarse_normal}}, half_size(size), "half of position");
    check_tiles(stage, in.tiles, size);
}

void validate(const FilterParams& params, const BlurInputs& in) {
    const char* stage = "filter.blur";
    check_params(stage, params);
    if (!in.irradiance) throw InputError(std::string(stage) + ": irradiance must be bound");
    const glm::ivec2 size{in.irradiance->width, in.irradiance->height};
    check_sizes(stage, {{"position", in.position}, {"normal", in.normal}}, size, "as irradiance");
    check_tiles(stage, in.tiles, size);
}

void run_reduce(const Image4& image, const RunOptions& options, Image4& reduced) {
    ReduceInputsView view = view_of(image);
    reduced = Image4(view.u.width, view.u.height);
    view.reduced = &reduced.data()->x;
    dispatch(options.isa, [&](auto isa) {
        parallel_bands(reduced.height, band, options,
                       [&](int first, int last) { Rows<isa()>::reduce(view, first, last); });
    });
}

void run(const FilterParams& params, const UpsampleInputs& in, const RunOptions& options, Image4& upsampled) {
    validate(params, in);
    upsampled = Image4(in.position->width, in.position->height);
    UpsampleInputsView view = view_of(params, in);
    view.upsampled = &upsampled.data()->x;
    dispatch(options.isa, [&](auto isa) {
        parallel_bands(upsampled.height, band, options,
                       [&](int first, int last) { Rows<isa()>::upsample(view, first, last, tiles_of(in.tiles)); });
    });
}

void run(const FilterParams& params, const BlurInputs& in, const RunOptions& options, Image4& blurred) {
    validate(params, in);
    const Buffer<float> spatial = spatial_weights(params, in.direction);
    Image4 result(in.irradiance->width, in.irradiance->height);
    BlurInputsView view = view_of(params, in, spatial);
    view.blurred = &result.data()->x;
    Scratch scratch(BlurPlanes::floats(result.width, blur_band, view.u.radius_y));
    dispatch(options.isa, [&](auto isa) {
        parallel_bands(result.height, blur_band, options, [&](int first, int last) {
            Buffer<float> planes = scratch.take();
            Rows<isa()>::blur(view, first, last, planes.data(), tiles_of(in.tiles));
            scratch.give(std::move(planes));
        });
    });
    blurred = std::move(result);
}

void run_blur(const FilterParams& params, const BlurInputs& in, const RunOptions& options, Image4& blurred) {
    BlurInputs one = in;
    if (params.blur == Blur::none) {
        validate(params, in);
        blurred = *in.irradiance;
    } else if (params.blur == Blur::full) {
        one.direction = Direction::both;
        run(params, one, options, blurred);
    } else {
        Image4 across;
        one.direction = Direction::horizontal;
        run(params, one, options, across);
        one.direction = Direction::vertical, one.irradiance = &across;
        run(params, one, options, blurred);
    }
}

std::vector<TapValue> explain_reduce(const Image4& image, glm::ivec2 pixel) {
    FpEnvironment environment;
    Recorder recorder;
    reduce<float>(view_of(image), pixel.x, pixel.y, recorder);
    return recorder.values;
}

std::vector<TapValue> explain(const FilterParams& params, const UpsampleInputs& in, glm::ivec2 pixel) {
    validate(params, in);
    FpEnvironment environment;
    Recorder recorder;
    upsample<float>(view_of(params, in), pixel.x, pixel.y, recorder);
    return recorder.values;
}

std::vector<TapValue> explain(const FilterParams& params, const BlurInputs& in, glm::ivec2 pixel) {
    validate(params, in);
    const Buffer<float> spatial = spatial_weights(params, in.direction);
    const BlurInputsView view = view_of(params, in, spatial);
    FpEnvironment environment;
    Recorder recorder;
    blur<float>(view.u, view.spatial, ImageTexels<float>{view, pixel.x, pixel.y}, recorder);
    return recorder.values;
}

StageInfo info_reduce() {
    StageInfo s;
    s.name = "filter.reduce";
    s.source = "VRSM 4.4 (indirect light at a quarter of the pixels)";
    s.inputs = {{"full", "image rgba32f", "", "position or normal of every pixel"}};
    s.outputs = {{"reduced", "image rgba32f", "", "one pixel of every 2 x 2"}};
    s.twin = "gi/filter/reduce.comp";
    return s;
}

StageInfo info_upsample() {
    FilterParams defaults;
    StageInfo s;
    s.name = "filter.upsample";
    s.source = "VRSM 4.5 (the indirect illumination buffer is first upsampled), fig. 4.4";
    s.inputs = {{"coarse_irradiance", "image rgba32f", "W/m2", "at half size; w: linear depth, m"},
                {"coarse_position", "image rgba32f", "m", "world-space position at half size"},
                {"coarse_normal", "image rgba32f", "", "unit normal at half size"},
                {"position", "image rgba32f", "m", "world-space position; w: linear depth"},
                {"normal", "image rgba32f", "", "unit normal"}};
    s.outputs = {{"upsampled", "image rgba32f", "W/m2", "irradiance of every pixel; w: linear depth, m"}};
    for (const Field& f : fields(defaults))
        if (f.name == "upsample" || f.name == "similarity" || f.name == "sigma_depth" || f.name == "sigma_normal")
            s.params.push_back(describe({f}).front());
    s.twin = "gi/filter/upsample.comp";
    return s;
}

StageInfo info_blur() {
    FilterParams defaults;
    StageInfo s;
    s.name = "filter.blur";
    s.source = "VRSM 4.5 (edge-aware blur, kernel 17)";
    s.inputs = {{"irradiance", "image rgba32f", "W/m2", "w: linear depth, m"},
                {"position", "image rgba32f", "m", "world-space position"},
                {"normal", "image rgba32f", "", "unit normal"},
                {"spatial", "buffer f32", "", "Gaussian of the distance within the kernel"}};
    s.outputs = {{"blurred", "image rgba32f", "W/m2", "irradiance; w: linear depth, m"}};
    for (const Field& f : fields(defaults))
        if (f.name != "resolution" && f.name != "upsample") s.params.push_back(describe({f}).front());
    s.twin = "gi/filter/blur.comp";
    return s;
}

}  // namespace plumb::filter
