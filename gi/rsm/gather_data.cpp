// One dispatch of a gather: its uniform block, and what it is lent.
#include <algorithm>
#include <cstdlib>

#include "core/host_math.h"
#include "gi/lend.h"
#include "gi/rsm/all_rays.h"
#include "gi/rsm/paths_kernel.h"
#include "raster/light_view.h"

namespace plumb::rsm {

float least_distance2(const GatherParams& params) {
    // Below 1e-37 m2 the inverse would overflow.
    return std::max(params.min_distance * params.min_distance, 1e-37f);
}

float irradiance_scale(const GatherParams& params) {
    return params.variant == Variant::published ? 1.0f : float(1 / host::pi);
}

int reach_of(const Pattern& pattern) {
    int reach = 0;
    for (const std::int32_t offset : pattern.offsets)
        reach = std::max({reach, std::abs(std::int32_t(std::int16_t(offset))), std::abs(offset >> 16)});
    float farthest = 0;
    for (const float d : pattern.positions) farthest = std::max(farthest, std::abs(d));
    return pattern.positions.empty() ? reach : int(farthest) + 2;
}

glm::dvec4 texel_area(const glm::dvec4& x, const glm::dvec4& y, const glm::dvec4& w) {
    auto cross = [](const glm::dvec4& a, const glm::dvec4& b) {
        return glm::dvec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
    };
    const glm::dvec3 yw = cross(y, w), wx = cross(w, x), xy = cross(x, y);
    const glm::dvec3 still = x.w * yw + y.w * wx + w.w * xy;
    return {still.x, still.y, still.z, -(x.x * yw.x + x.y * yw.y + x.z * yw.z)};
}

namespace {

// False where no float holds it: samples of such a map are points.
bool set_texel_area(const View& view, int size, float (&area)[4]) {
    const glm::dmat4 clip = view.world_to_clip();
    auto row = [&](int r) { return glm::dvec4(clip[0][r], clip[1][r], clip[2][r], clip[3][r]); };
    const glm::dvec4 w = row(3), of = texel_area((row(0) + w) * (0.5 * size), (row(1) + w) * (0.5 * size), w);
    for (int c = 0; c < 4; ++c)
        if (!(std::abs(of[c]) < 1e30)) return false;
    for (int c = 0; c < 4; ++c) area[c] = float(of[c]);
    return true;
}

// The members that the blocks share.
template <class Uniforms>
Uniforms shared_uniforms(const GatherParams& params, const GatherInputs& in) {
    Uniforms u{};
    u.map = raster::projection_args(in.rsm->view, in.rsm->size, params.projection == Projection::clamped);
    u.least_distance2 = least_distance2(params);
    u.scale = irradiance_scale(params);
    u.width = in.position->width;
    u.height = in.position->height;
    u.rotations = params.rotations;
    u.seed = in.seed;
    if (in.pattern) u.reach = reach_of(*in.pattern);
    const bool samples = params.gather == Gather::disc || params.gather == Gather::paths;
    if (samples && turn_of(params) == Turn::tile) u.tile = tile_of(params.rotations);
    if (samples && params.sample_area == SampleArea::texels && params.variant == Variant::corrected) {
        if (set_texel_area(in.rsm->view, in.rsm->size, u.texel_area)) u.sample_area = float(1 / host::pi);
    }
    return u;
}

std::vector<unsigned char> block_of(const GatherParams& params, const GatherInputs& in) {
    if (params.gather != Gather::paths) {
        auto u = shared_uniforms<GatherUniforms>(params, in);
        u.samples = sample_count(params);
        return uniform_block(u);
    }
    auto u = shared_uniforms<PathsUniforms>(params, in);
    for (int c = 0; c < 3; ++c) u.axis[c] = float(-in.rsm->view.forward[c]);
    u.directions = params.directions;
    u.steps = params.steps;
    const float texels = params.fade * float(in.rsm->size);
    u.fade = texels > 1e-30f ? 1 / texels : 1e30f;
    u.slots = params.visibility == Visibility::none ? 0 : params.slots;
    u.propagates = params.visibility == Visibility::algorithm_2 ? 0 : -1;
    u.thickness = params.thickness;
    return uniform_block(u);
}

// Its images for a device, its records for us: a map may have either.
void lend_map(StageData& d, const raster::Rsm& map) {
    if (!map.flux.empty())
        lend(d, {{"rsm_position", &map.position}, {"rsm_normal", &map.normal}, {"rsm_flux", &map.flux}});
    const Shape shape{std::int64_t(map.size) * map.size, record_stride};
    if (map.half)
        lend(d.inputs, "rsm_records", shape, map.half_records.data());
    else if (!map.records.empty())
        lend(d.inputs, "rsm_records", shape, map.records.data());
}

void lend_pattern(StageData& d, const GatherParams& params, const Pattern& pattern) {
    const int samples = pattern.samples, rotations = pattern.rotations;
    if (params.texels == Texels::whole)
        lend(d.inputs, "offsets", {samples, rotations}, pattern.offsets.data());
    else
        lend(d.inputs, "positions", {samples, rotations, 2}, pattern.positions.data());
    if (params.gather == Gather::disc) return void(lend(d.inputs, "weights", {samples}, pattern.weights.data()));
    lend(d.inputs, "weights", {samples, rotations}, pattern.weights.data());
    const Buffer<float> edges = slot_edges(params);
    add(d.inputs, "edges", {std::int64_t(edges.size())}, edges.data());
}

}  // namespace

StageData data_of(const GatherParams& params, const GatherInputs& in) {
    validate(params, in);
    StageData d = begin_data(stage_of(params), size_of(*in.position), block_of(params, in));
    lend(d, {{"position", in.position}, {"normal", in.normal}});
    lend_map(d, *in.rsm);
    if (params.gather != Gather::all) lend_pattern(d, params, *in.pattern);
    lend_tiles(d, in.tiles);
    return d;
}

}  // namespace plumb::rsm
