#include "core/host_math.h"
#include "gi/isr/isr.h"
#include "gi/isr/sample_uniforms.h"

namespace plumb::isr {

namespace {

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
    const IsrParams p = resolved(params);
    u.rotations = p.rotations, u.seed = seed;
    u.tile = p.turn == Turn::tile ? tile_of(p.rotations) : 0;
    u.published = params.variant == Variant::published ? 1 + int(params.solid_angle) : 0;
    u.inverse_matrix = params.position == Position::inverse_matrix;
    u.least_cosine = params.least_cosine;
    return u;
}

// Of published: what the sums of (25) and (26) are multiplied by.
float scale_of(const IsrParams& params, int rings) {
    return params.solid_angle == SolidAngle::none ? 1.0f : float(2 * host::pi / sample_count(rings));
}

void check_pattern(const char* stage, const Pattern* pattern, int rings, const IsrParams& params) {
    if (!pattern) throw InputError(fmt::format("{}: pattern must be bound", stage));
    const int rotations = resolved(params).rotations;
    const std::size_t offsets = std::size_t(sample_count(rings)) * std::size_t(rotations);
    if (pattern->samples != sample_count(rings) || pattern->rotations != rotations || pattern->offsets.size() != offsets ||
        pattern->weights.size() != std::size_t(pattern->samples))
        throw InputError(fmt::format("{}: pattern has {} samples in {} rotations: expected {} in {}", stage,
                                     pattern->samples, pattern->rotations, sample_count(rings), rotations));
}

SampleUniforms uniforms(const IsrParams& params, const SsaoInputs& in) {
    SampleUniforms u = sample_uniforms(params, *in.surface, *in.source_surface, in.margin, in.camera, in.seed);
    const double side = in.camera.footprint * double(params.ssao_spacing);
    u.rings = params.ssao_rings;
    u.full_reach = 3.4e38f;
    u.area = float(side * side / host::pi);
    u.scale = scale_of(params, params.ssao_rings);
    u.per_length = params.length_unit > 0 ? float(1 / double(params.length_unit)) : 0;
    return u;
}

}  // namespace

SampleUniforms uniforms(const IsrParams& params, const GatherInputs& in) {
    SampleUniforms u = sample_uniforms(params, *in.surface, *in.source_surface, in.margin, in.camera, in.seed);
    const double side = in.camera.footprint * (in.pattern ? in.pattern->side : 0);
    u.rings = params.rings;
    u.far_rings = params.far_rings;
    u.full_reach = params.far_rings > 0 ? float(params.rings * double(params.full_depth)) : 3.4e38f;
    u.area = float(side * side);
    u.scale = scale_of(params, params.rings);
    return u;
}

void lend_offsets(StageData& data, const char* stage, const Pattern* pattern, int rings, const IsrParams& params) {
    check_pattern(stage, pattern, rings, params);
    lend(data.inputs, "offsets", {std::int64_t(pattern->offsets.size())}, pattern->offsets.data());
}

StageData data_of(const IsrParams& params, const GatherInputs& in) {
    const char* stage = "isr.gather";
    validate(params);
    bound(stage, "source_surface", in.source_surface);
    const glm::ivec2 size = size_of(bound(stage, "surface", in.surface));
    StageData d = begin_data<GatherKernel>(size, uniforms(params, in));
    lend(d, {{"surface", in.surface}, {"source_surface", in.source_surface}, {"source_radiosity", in.source_radiosity}});
    if (in.before) lend(d, {{"before", in.before}});
    lend_offsets(d, stage, in.pattern, params.rings, params);
    lend(d.inputs, "weights", {std::int64_t(in.pattern->weights.size())}, in.pattern->weights.data());
    lend_tiles(d, in.tiles);
    return d;
}

StageData data_of(const IsrParams& params, const SsaoInputs& in) {
    const char* stage = "isr.ssao";
    validate(params);
    bound(stage, "source_surface", in.source_surface);
    const glm::ivec2 size = size_of(bound(stage, "surface", in.surface));
    StageData d = begin_data<SsaoKernel>(size, uniforms(params, in));
    lend(d, {{"surface", in.surface}, {"source_surface", in.source_surface}});
    if (in.gathered) lend(d, {{"gathered", in.gathered}});
    lend_offsets(d, stage, in.pattern, params.ssao_rings, params);
    lend_tiles(d, in.tiles);
    return d;
}

StageData data_of(const IsrParams& params, const BounceInputs& in) {
    const char* stage = "isr.bounce";
    const glm::ivec2 size = size_of(bound(stage, "radiosity", in.radiosity));
    const glm::ivec2 receivers = size_of(bound(stage, "reflectance", in.reflectance));
    if (in.margin < 0 || size.x < receivers.x + in.margin || size.y < receivers.y + in.margin)
        throw InputError(fmt::format("{}: margin = {}: expected 0 or more, and radiosity of at least {} x {}: it is {} x {}",
                                     stage, in.margin, receivers.x + in.margin, receivers.y + in.margin, size.x, size.y));
    StageData d = begin_data<BounceKernel>(size, BounceUniforms{size.x, size.y, receivers.x, receivers.y, in.margin,
                                                               params.variant == Variant::published, {}});
    lend(d, {{"radiosity", in.radiosity}, {"reflectance", in.reflectance}, {"gathered", in.gathered}});
    return d;
}

Excess excess_of(const Image4& surface, const Image4& gathered) {
    if (size_of(gathered) != size_of(surface))
        throw InputError(fmt::format("isr.gather: gathered is {} x {}: expected {} x {}, as surface", gathered.width,
                                     gathered.height, surface.width, surface.height));
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

}  // namespace plumb::isr
