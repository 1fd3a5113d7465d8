#include "gi/isr/isr.h"
#include "gi/isr/sample_uniforms.h"

namespace plumb::isr {

namespace {

// How much farther than what a view sees a surface may lie and still be what it sees: coarse pixels hold the mean depth of
// four, and the two views' pixels lie elsewhere on a slanted surface. Ours.
constexpr double tolerance = 0.05;

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
SampleUniforms own_uniforms(const IsrParams& params, const Image4& surface, const CoarseCamera& camera,
                            const Pattern* pattern) {
    GatherInputs own;
    own.pattern = pattern;
    own.surface = own.source_surface = &surface;
    own.camera = camera;
    return uniforms(params, own);
}

UnseenUniforms uniforms(const IsrParams& params, const UnseenInputs& in) {
    UnseenUniforms u{};
    u.u = own_uniforms(params, *in.surface, in.camera, nullptr);
    u.view = projection_of(in.camera.eye, in.view, *in.view_surface, in.margin);
    u.reach = float(1 + tolerance);
    return u;
}

GatherCameraUniforms uniforms(const IsrParams& params, const CameraGatherInputs& in) {
    GatherCameraUniforms u{};
    GatherInputs receivers;
    receivers.surface = in.surface, receivers.source_surface = in.source_surface;
    receivers.camera = in.camera, receivers.seed = in.seed, receivers.pattern = in.pattern;
    u.u = uniforms(params, receivers);
    u.camera = own_uniforms(params, *in.source_surface, in.source_camera, in.pattern);
    u.view = projection_of(in.camera.eye, in.source_camera, *in.source_surface, 0);
    u.camera_eye = glm::vec4(glm::vec3(in.source_camera.eye - in.camera.eye), 0.0f);
    return u;
}

}  // namespace

StageData data_of(const IsrParams& params, const UnseenInputs& in) {
    const char* stage = "isr.unseen";
    validate(params);
    bound(stage, "view_surface", in.view_surface);
    const glm::ivec2 size = size_of(bound(stage, "surface", in.surface));
    StageData d = begin_data<UnseenKernel>(size, uniforms(params, in));
    lend(d, {{"surface", in.surface}, {"view_surface", in.view_surface}});
    return d;
}

StageData data_of(const IsrParams& params, const CameraGatherInputs& in) {
    const char* stage = "isr.gather_camera";
    validate(params);
    if (params.variant == Variant::published)
        throw InputError(fmt::format("{}: variant = published: ISR prints no equation for additional cameras", stage));
    bound(stage, "source_surface", in.source_surface);
    const glm::ivec2 size = size_of(bound(stage, "surface", in.surface));
    StageData d = begin_data<GatherCameraKernel>(size, uniforms(params, in));
    lend(d, {{"surface", in.surface}, {"source_surface", in.source_surface}, {"source_radiosity", in.source_radiosity}});
    if (in.before) lend(d, {{"before", in.before}});
    lend_offsets(d, stage, in.pattern, params.rings, params);
    lend(d.inputs, "weights", {std::int64_t(in.pattern->weights.size())}, in.pattern->weights.data());
    lend_tiles(d, in.tiles);
    return d;
}

}  // namespace plumb::isr
