#include <fmt/format.h>

#include "core/error.h"
#include "core/fp_environment.h"
#include "core/parallel.h"
#include "gi/isr/cameras_inputs.h"
#include "gi/isr/cameras_rows.h"
#include "gi/isr/gather_inputs.h"

namespace plumb::isr {

namespace {

constexpr int band = raster::Covered::side;  // rows

// How much farther than what a view sees a surface may lie and still be what it sees: coarse pixels hold the mean depth of
// four, and the two views' pixels lie elsewhere on a slanted surface. Ours.
constexpr double tolerance = 0.05;

void check_bound(const char* stage, std::initializer_list<std::pair<const char*, const void*>> inputs) {
    for (const auto& [name, input] : inputs)
        if (!input) throw InputError(fmt::format("{}: {} must be bound", stage, name));
}

void check_size(const char* stage, const char* name, const Image4& image, glm::ivec2 size, const char* why) {
    if (glm::ivec2(image.width, image.height) != size)
        throw InputError(fmt::format("{}: {} is {} x {}: expected {} x {}, {}", stage, name, image.width, image.height,
                                     size.x, size.y, why));
}

glm::ivec2 size_of(const Image4& image) { return {image.width, image.height}; }

// From points relative to `from` to the coarse image of `camera`, which has `margin` pixels around it.
ViewProjection projection_of(const glm::dvec3& from, const CoarseCamera& camera, const Image4& image, int margin) {
    // A point at eye depth 1 m is f_o + x f_u + y f_v: x and y count from the centre of pixel (0, 0).
    const glm::dvec3 forward = -glm::dvec3(camera.view_to_world[2]);
    auto row = [&](const glm::dvec3& step) {
        const double length2 = step.x * step.x + step.y * step.y + step.z * step.z;
        const glm::dvec3 per_pixel = step / length2;
        const double at_centre = per_pixel.x * camera.f_o.x + per_pixel.y * camera.f_o.y + per_pixel.z * camera.f_o.z;
        return glm::vec4(glm::vec3(per_pixel + (0.5 + margin - at_centre) * forward), 0.0f);
    };
    ViewProjection v{};
    v.eye = glm::vec4(glm::vec3(from - camera.eye), 0.0f);
    v.to_x = row(camera.f_u), v.to_y = row(camera.f_v);
    v.forward = glm::vec4(glm::vec3(forward), 0.0f);
    v.width = image.width, v.height = image.height, v.margin = margin;
    v.least_depth = std::max(float(camera.near), 1e-30f);
    return v;
}

// The uniforms of gathering from a camera's own image.
SampleUniforms own_uniforms(const IsrParams& params, const Image4& surface, const CoarseCamera& camera) {
    GatherInputs own;
    own.surface = own.source_surface = &surface;
    own.camera = camera;
    return uniforms(params, own);
}

UnseenInputsView view_of(const IsrParams& params, const UnseenInputs& in) {
    return {uniforms(params, in), &in.surface->data()->x, &in.view_surface->data()->x, nullptr};
}

GatherCameraInputsView view_of(const IsrParams& params, const CameraGatherInputs& in) {
    return {uniforms(params, in),
            &in.surface->data()->x,
            &in.source_surface->data()->x,
            &in.source_radiosity->data()->x,
            in.before ? &in.before->data()->x : nullptr,
            in.pattern->offsets.data(),
            nullptr};
}

}  // namespace

void validate(const IsrParams& params, const UnseenInputs& in) {
    validate(params);
    check_bound("isr.unseen", {{"surface", in.surface}, {"view_surface", in.view_surface}});
    if (in.surface->empty() || in.view_surface->empty()) throw InputError("isr.unseen: an image without pixels is bound");
}

void validate(const IsrParams& params, const CameraGatherInputs& in) {
    const char* stage = "isr.gather_camera";
    validate(params);
    check_bound(stage, {{"surface", in.surface}, {"source_surface", in.source_surface},
                        {"source_radiosity", in.source_radiosity}, {"pattern", in.pattern}});
    if (in.surface->empty() || in.source_surface->empty())
        throw InputError(fmt::format("{}: an image without pixels is bound", stage));
    check_size(stage, "source_radiosity", *in.source_radiosity, size_of(*in.source_surface), "as source_surface");
    if (in.before) check_size(stage, "before", *in.before, size_of(*in.surface), "as surface");
    if (params.variant == Variant::published)
        throw InputError(fmt::format("{}: variant = published: ISR prints no equation for additional cameras", stage));
    const std::size_t offsets = std::size_t(sample_count(params.rings)) * std::size_t(params.rotations);
    if (in.pattern->offsets.size() != offsets)
        throw InputError(fmt::format("{}: pattern has {} offsets: expected {} samples in {} rotations", stage,
                                     in.pattern->offsets.size(), sample_count(params.rings), params.rotations));
    if (in.tiles && !in.tiles->fits(size_of(*in.surface)))
        throw InputError(fmt::format("{}: tiles are of another size", stage));
}

UnseenUniforms uniforms(const IsrParams& params, const UnseenInputs& in) {
    UnseenUniforms u{};
    u.u = own_uniforms(params, *in.surface, in.camera);
    u.view = projection_of(in.camera.eye, in.view, *in.view_surface, in.margin);
    u.reach = float(1 + tolerance);
    return u;
}

GatherCameraUniforms uniforms(const IsrParams& params, const CameraGatherInputs& in) {
    GatherCameraUniforms u{};
    GatherInputs receivers;
    receivers.surface = in.surface, receivers.source_surface = in.source_surface;
    receivers.camera = in.camera, receivers.seed = in.seed;
    u.u = uniforms(params, receivers);
    u.camera = own_uniforms(params, *in.source_surface, in.source_camera);
    u.view = projection_of(in.camera.eye, in.source_camera, *in.source_surface, 0);
    u.camera_eye = glm::vec4(glm::vec3(in.source_camera.eye - in.camera.eye), 0.0f);
    return u;
}

void run(const IsrParams& params, const UnseenInputs& in, const RunOptions& options, Image4& unseen) {
    validate(params, in);
    Image4 result(in.surface->width, in.surface->height);
    UnseenInputsView view = view_of(params, in);
    view.unseen = &result.data()->x;
    dispatch(options.isa, [&](auto isa) {
        parallel_bands(result.height, band, options,
                       [&](int first, int last) { CameraRows<isa()>::unseen(view, first, last); });
    });
    unseen = std::move(result);
}

void run(const IsrParams& params, const CameraGatherInputs& in, const RunOptions& options, Image4& gathered) {
    validate(params, in);
    Image4 result(in.surface->width, in.surface->height);
    GatherCameraInputsView view = view_of(params, in);
    view.gathered = &result.data()->x;
    dispatch(options.isa, [&](auto isa) {
        parallel_bands(result.height, band, options, [&](int first, int last) {
            CameraRows<isa()>::gather_camera(view, first, last, in.tiles ? in.tiles->row(first) : nullptr);
        });
    });
    gathered = std::move(result);
}

std::vector<TapValue> explain(const IsrParams& params, const UnseenInputs& in, glm::ivec2 pixel) {
    validate(params, in);
    FpEnvironment environment;
    Recorder recorder;
    unseen<float>(view_of(params, in), pixel.x, pixel.y, recorder);
    return recorder.values;
}

std::vector<TapValue> explain(const IsrParams& params, const CameraGatherInputs& in, glm::ivec2 pixel) {
    validate(params, in);
    FpEnvironment environment;
    Recorder recorder;
    gather_camera<float>(view_of(params, in), pixel.x, pixel.y, recorder);
    return recorder.values;
}

StageInfo info_unseen() {
    StageInfo s;
    s.name = "isr.unseen";
    s.source = "ISR chapter 6 (additional cameras): what only they see";
    s.inputs = {{"surface", "image rgba32f", "m", "of the additional camera: xyz unit normal, w depth"},
                {"view_surface", "image rgba32f", "m", "of a view whose light is gathered already"}};
    s.outputs = {{"unseen", "image rgba32f", "m", "the camera's surface; 0 where the view sees the same"}};
    s.params = params_of({"position"});
    s.twin = "gi/isr/unseen.comp";
    return s;
}

StageInfo info_gather_camera() {
    StageInfo s;
    s.name = "isr.gather_camera";
    s.source = "ISR chapter 6 (additional cameras), (25) and (6)";
    s.inputs = {{"surface", "image rgba32f", "m", "of the receivers: xyz unit normal, w depth"},
                {"source_surface", "image rgba32f", "m", "what only the camera sees: xyz unit normal, w depth"},
                {"source_radiosity", "image rgba32f", "W/m2", "of the camera's coarse pixels"},
                {"before", "image rgba32f", "W/m2", "what other sources sent; w: sum of form factors"},
                {"offsets", "buffer i32", "coarse pixels", "of the samples, [samples][rotations]"}};
    s.outputs = {{"gathered", "image rgba32f", "W/m2", "irradiance; w: sum of form factors"}};
    s.params = params_of({"rings", "spacing", "rotations", "far_rings", "full_depth", "cameras", "camera_angle", "position",
                          "least_cosine"});
    s.twin = "gi/isr/gather_camera.comp";
    return s;
}

}  // namespace plumb::isr
