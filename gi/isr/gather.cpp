#include <fmt/format.h>

#include "core/error.h"
#include "core/fp_environment.h"
#include "core/host_math.h"
#include "core/parallel.h"
#include "gi/isr/gather_inputs.h"
#include "gi/scratch.h"

namespace plumb::isr {

namespace {

constexpr int band = 32;  // rows of receivers, which share the rows of sources around them

void check_bound(const char* stage, std::initializer_list<std::pair<const char*, const void*>> inputs) {
    for (const auto& [name, input] : inputs)
        if (!input) throw InputError(fmt::format("{}: {} must be bound", stage, name));
}

void check_same_size(const char* stage, const char* name, const Image4& image, const char* other, const Image4& like) {
    if (image.width != like.width || image.height != like.height)
        throw InputError(fmt::format("{}: {} is {} x {}: expected {} x {}, as {}", stage, name, image.width, image.height,
                                     like.width, like.height, other));
}

void check_margin(const char* stage, int margin, const char* name, const Image4& sources, const Image4& receivers) {
    if (margin < 0 || sources.width < receivers.width + margin || sources.height < receivers.height + margin)
        throw InputError(fmt::format("{}: margin = {}: expected 0 or more, and {} of at least {} x {}: it is {} x {}", stage,
                                     margin, name, receivers.width + margin, receivers.height + margin, sources.width,
                                     sources.height));
}

void check_pattern(const char* stage, const Pattern& pattern, int rings, int rotations) {
    const std::size_t offsets = std::size_t(sample_count(rings)) * std::size_t(rotations);
    if (pattern.samples != sample_count(rings) || pattern.rotations != rotations || pattern.offsets.size() != offsets)
        throw InputError(fmt::format("{}: pattern has {} samples in {} rotations: expected {} in {}", stage,
                                     pattern.samples, pattern.rotations, sample_count(rings), rotations));
}

void check_tiles(const char* stage, const raster::Covered* tiles, const Image4& image) {
    if (tiles && !tiles->fits({image.width, image.height}))
        throw InputError(fmt::format("{}: tiles are of another size", stage));
}

Tiles tiles_of(const raster::Covered* tiles) { return tiles ? Tiles{tiles->any.data(), tiles->tiles.x} : Tiles{}; }

const float* texels_of(const Image4* image) { return image ? &image->data()->x : nullptr; }

// What isr.gather and isr.ssao have in common. Columns of the matrix that takes (x, y, clip depth, 1) to a point over its
// eye depth, and 1 / eye depth: through clip and view space, as a program does that inverts its matrices (ISR 4.7).
void set_camera(SampleUniforms& u, const CoarseCamera& camera) {
    // Pixels to clip space: the point at eye depth 1 m seen by pixel (x, y) in view space, through the projection.
    const glm::dmat4 to_view = glm::transpose(camera.view_to_world);
    const glm::dvec4 o = to_view * glm::dvec4(camera.f_o, 0), right = to_view * glm::dvec4(camera.f_u, 0),
                     down = to_view * glm::dvec4(camera.f_v, 0);
    const glm::dmat4& m = camera.clip_to_view;
    glm::dmat4 pixel_to_clip(1);
    pixel_to_clip[0][0] = right.x / m[0][0], pixel_to_clip[1][1] = down.y / m[1][1];
    pixel_to_clip[3] = {(o.x - m[3][0]) / m[0][0], (o.y - m[3][1]) / m[1][1], 0, 1};
    const glm::dmat4 from_pixel = camera.view_to_world * m * pixel_to_clip;
    u.right = glm::vec4(glm::vec3(camera.f_u), float(from_pixel[0].w));
    u.down = glm::vec4(glm::vec3(camera.f_v), float(from_pixel[1].w));
    u.of_depth = glm::vec4(from_pixel[2]);
    u.origin = glm::vec4(glm::vec3(camera.f_o), float(from_pixel[3].w));
}

SampleUniforms sample_uniforms(const IsrParams& params, const Image4& surface, const Image4& sources, int margin,
                               const CoarseCamera& camera, std::uint32_t seed) {
    SampleUniforms u{};
    set_camera(u, camera);
    u.width = surface.width, u.height = surface.height;
    u.source_width = sources.width, u.source_height = sources.height;
    u.margin = margin;
    u.rotations = params.rotations, u.seed = seed;
    u.published = params.variant == Variant::published;
    u.inverse_matrix = params.position == Position::inverse_matrix;
    u.least_cosine = params.least_cosine;
    return u;
}

GatherInputsView view_of(const IsrParams& params, const GatherInputs& in) {
    return {uniforms(params, in),         texels_of(in.surface), texels_of(in.source_surface),
            texels_of(in.source_radiosity), texels_of(in.before),  in.pattern->offsets.data(), nullptr};
}

SsaoInputsView view_of(const IsrParams& params, const SsaoInputs& in) {
    return {uniforms(params, in),   texels_of(in.surface),      texels_of(in.source_surface),
            texels_of(in.gathered), in.pattern->offsets.data(), nullptr};
}

BounceInputsView view_of(const BounceInputs& in) {
    return {uniforms(in), texels_of(in.radiosity), texels_of(in.reflectance), texels_of(in.gathered), nullptr};
}

// rows(isa, planes, first, last) for all bands, with the sources that a band reaches, not yet taken apart; null where
// samples are fetched.
template <class Rows>
void run_bands(const SampleUniforms& u, int count, int reach, const RunOptions& options, Rows rows) {
    const bool apart = u.rotations == 1;
    Scratch scratch(apart ? SourcePlanes::floats(u, count, reach, band) : 0);
    dispatch(options.isa, [&](auto isa) {
        parallel_bands(u.height, band, options, [&](int first, int last) {
            Buffer<float> own = scratch.take();
            const SourcePlanes planes(u, count, reach, first, last, own.data());
            rows(isa, apart ? &planes : nullptr, first, last);
            scratch.give(std::move(own));
        });
    });
}

}  // namespace

void validate(const IsrParams& params, const GatherInputs& in) {
    const char* stage = "isr.gather";
    validate(params);
    check_bound(stage, {{"surface", in.surface}, {"source_surface", in.source_surface},
                        {"source_radiosity", in.source_radiosity}, {"pattern", in.pattern}});
    check_same_size(stage, "source_radiosity", *in.source_radiosity, "source_surface", *in.source_surface);
    if (in.before) check_same_size(stage, "before", *in.before, "surface", *in.surface);
    check_margin(stage, in.margin, "source_surface", *in.source_surface, *in.surface);
    check_pattern(stage, *in.pattern, params.rings, params.rotations);
    check_tiles(stage, in.tiles, *in.surface);
}

void validate(const IsrParams& params, const SsaoInputs& in) {
    const char* stage = "isr.ssao";
    validate(params);
    check_bound(stage, {{"surface", in.surface}, {"source_surface", in.source_surface}, {"pattern", in.pattern}});
    if (in.gathered) check_same_size(stage, "gathered", *in.gathered, "surface", *in.surface);
    check_margin(stage, in.margin, "source_surface", *in.source_surface, *in.surface);
    check_pattern(stage, *in.pattern, params.ssao_rings, params.rotations);
    check_tiles(stage, in.tiles, *in.surface);
}

void validate(const BounceInputs& in) {
    const char* stage = "isr.bounce";
    check_bound(stage, {{"radiosity", in.radiosity}, {"reflectance", in.reflectance}, {"gathered", in.gathered}});
    check_same_size(stage, "gathered", *in.gathered, "reflectance", *in.reflectance);
    check_margin(stage, in.margin, "radiosity", *in.radiosity, *in.reflectance);
}

SampleUniforms uniforms(const IsrParams& params, const GatherInputs& in) {
    SampleUniforms u = sample_uniforms(params, *in.surface, *in.source_surface, in.margin, in.camera, in.seed);
    const double side = in.camera.footprint * double(params.spacing);
    u.rings = params.rings;
    u.far_rings = params.far_rings;
    u.full_reach = params.far_rings > 0 ? float(params.rings * double(params.full_depth)) : 3.4e38f;
    u.area = float(side * side);
    u.scale = float(2 * host::pi / sample_count(params.rings));
    return u;
}

SampleUniforms uniforms(const IsrParams& params, const SsaoInputs& in) {
    SampleUniforms u = sample_uniforms(params, *in.surface, *in.source_surface, in.margin, in.camera, in.seed);
    const double side = in.camera.footprint * double(params.ssao_spacing);
    u.rings = params.ssao_rings;
    u.full_reach = 3.4e38f;
    u.area = float(side * side / host::pi);
    u.scale = float(2 * host::pi / sample_count(params.ssao_rings));
    return u;
}

BounceUniforms uniforms(const BounceInputs& in) {
    return {in.radiosity->width, in.radiosity->height, in.reflectance->width, in.reflectance->height, in.margin, {}};
}

void run(const IsrParams& params, const GatherInputs& in, const RunOptions& options, Image4& gathered) {
    validate(params, in);
    Image4 result(in.surface->width, in.surface->height);
    GatherInputsView view = view_of(params, in);
    view.gathered = &result.data()->x;
    const auto rows = [&](auto isa, const SourcePlanes* planes, int first, int last) {
        if (planes) GatherRows<isa()>::take_apart(view, *planes);
        GatherRows<isa()>::gather(view, planes, first, last, tiles_of(in.tiles));
    };
    run_bands(view.u, SourcePlanes::of_gather, in.pattern->reach, options, rows);
    gathered = std::move(result);
}

void run(const IsrParams& params, const SsaoInputs& in, const RunOptions& options, Image4& lit) {
    validate(params, in);
    Image4 result(in.surface->width, in.surface->height, glm::vec4(0, 0, 0, 1));
    SsaoInputsView view = view_of(params, in);
    view.lit = &result.data()->x;
    const auto rows = [&](auto isa, const SourcePlanes* planes, int first, int last) {
        if (planes) GatherRows<isa()>::take_apart(view, *planes);
        GatherRows<isa()>::ssao(view, planes, first, last, tiles_of(in.tiles));
    };
    run_bands(view.u, SourcePlanes::of_ssao, in.pattern->reach, options, rows);
    lit = std::move(result);
}

void run(const IsrParams&, const BounceInputs& in, const RunOptions& options, Image4& radiosity) {
    validate(in);
    Image4 result(in.radiosity->width, in.radiosity->height);
    BounceInputsView view = view_of(in);
    view.bounced = &result.data()->x;
    dispatch(options.isa, [&](auto isa) {
        parallel_bands(result.height, band, options,
                       [&](int first, int last) { GatherRows<isa()>::bounce(view, first, last); });
    });
    radiosity = std::move(result);
}

Excess excess_of(const Image4& surface, const Image4& gathered) {
    check_same_size("isr.gather", "gathered", gathered, "surface", surface);
    Excess excess;
    double pixels = 0, above = 0;
    for (std::size_t i = 0; i < surface.size(); ++i) {
        const glm::vec4 s = surface.texels[i];
        if (!(s.x * s.x + s.y * s.y + s.z * s.z > 0)) continue;
        const double forms = double(gathered.texels[i].w);
        pixels += 1;
        // What is no number counts as too much.
        if (!(forms <= 1)) above += 1;
        if (!(forms <= excess.largest)) excess.largest = forms;
    }
    excess.share = pixels > 0 ? above / pixels : 0;
    return excess;
}

std::vector<TapValue> explain(const IsrParams& params, const GatherInputs& in, glm::ivec2 pixel) {
    validate(params, in);
    const GatherInputsView view = view_of(params, in);
    FpEnvironment environment;
    Recorder recorder;
    const SourceImages<float> sources{view, pixel.x, pixel.y, rotation_of<float>(view.u, pixel.x, pixel.y)};
    gather<float>(view, pixel.x, pixel.y, sources, recorder);
    return recorder.values;
}

std::vector<TapValue> explain(const IsrParams& params, const SsaoInputs& in, glm::ivec2 pixel) {
    validate(params, in);
    const SsaoInputsView view = view_of(params, in);
    FpEnvironment environment;
    Recorder recorder;
    const SphereImage<float> spheres{view, pixel.x, pixel.y, rotation_of<float>(view.u, pixel.x, pixel.y)};
    ssao<float>(view, pixel.x, pixel.y, spheres, recorder);
    return recorder.values;
}

std::vector<TapValue> explain(const IsrParams&, const BounceInputs& in, glm::ivec2 pixel) {
    validate(in);
    const BounceInputsView view = view_of(in);
    FpEnvironment environment;
    Recorder recorder;
    bounce<float>(view, pixel.x, pixel.y, recorder);
    return recorder.values;
}

StageInfo info_gather() {
    StageInfo s;
    s.name = "isr.gather";
    s.source = "ISR 4.4, (25) and (6): one bounce between what the camera sees";
    s.inputs = {{"surface", "image rgba32f", "m", "of the receivers: xyz unit normal, w depth"},
                {"source_surface", "image rgba32f", "m", "where light comes from: xyz unit normal, w depth"},
                {"source_radiosity", "image rgba32f", "W/m2", "w: radiation mask"},
                {"before", "image rgba32f", "W/m2", "what other sources sent; w: sum of form factors"},
                {"offsets", "buffer i32", "coarse pixels", "of the samples, [samples][rotations]"}};
    s.outputs = {{"gathered", "image rgba32f", "W/m2", "irradiance; w: sum of form factors"}};
    s.params = params_of({"variant", "rings", "spacing", "rotations", "far_rings", "full_depth", "position", "least_cosine"});
    s.twin = "gi/isr/gather.comp";
    return s;
}

StageInfo info_ssao() {
    StageInfo s;
    s.name = "isr.ssao";
    s.source = "ISR 4.4, (26): ambient occlusion by what the camera sees";
    s.inputs = {{"surface", "image rgba32f", "m", "of the receivers: xyz unit normal, w depth"},
                {"source_surface", "image rgba32f", "m", "what occludes: xyz unit normal, w depth"},
                {"gathered", "image rgba32f", "W/m2", "irradiance, which goes through"},
                {"offsets", "buffer i32", "coarse pixels", "of the samples, [samples][rotations]"}};
    s.outputs = {{"lit", "image rgba32f", "W/m2", "irradiance; w: accessibility"}};
    s.params = params_of({"variant", "ssao_rings", "ssao_spacing", "rotations", "position"});
    s.twin = "gi/isr/ssao.comp";
    return s;
}

StageInfo info_bounce() {
    StageInfo s;
    s.name = "isr.bounce";
    s.source = "ISR chapter 6 (more bounces), (8): B = B0 + rho E";
    s.inputs = {{"radiosity", "image rgba32f", "W/m2", "B0 of all sources; w: radiation mask"},
                {"reflectance", "image rgba32f", "", "of the receivers"},
                {"gathered", "image rgba32f", "W/m2", "irradiance of the receivers"}};
    s.outputs = {{"bounced", "image rgba32f", "W/m2", "B of all sources; w: radiation mask"}};
    s.params = params_of({"bounces"});
    s.twin = "gi/isr/bounce.comp";
    return s;
}

}  // namespace plumb::isr
