#include "gi/screen/ssao.h"

#include <algorithm>
#include <cmath>

#include "core/hash.h"
#include "core/host_math.h"
#include "core/sequences.h"
#include "gi/lend.h"

namespace plumb::screen {

namespace {

float unit(int i, int channel, std::uint32_t seed) {
    const auto h = pixel_hash<std::int32_t>(i, channel, 0, std::int32_t(seed));
    return float(std::uint32_t(h.x) >> 8) * 0x1p-24f;
}

// A point of the cube -1..1, -1..1, 0..1 (z 0 for a vector in its floor), as the listings draw it.
glm::dvec3 of_cube(int i, bool flat, std::uint32_t seed) {
    return {2.0 * double(unit(i, 0, seed)) - 1, 2.0 * double(unit(i, 1, seed)) - 1, flat ? 0 : double(unit(i, 2, seed))};
}

constexpr std::uint32_t seed_of_samples = 1, seed_of_rotations = 2;

}  // namespace

SeenFrom seen_from(const View& view, glm::ivec2 size) {
    SeenFrom s{};
    const glm::vec3 anchor(view.eye);
    glm::dmat4 from_anchor(1);
    from_anchor[3] = glm::dvec4(glm::dvec3(anchor), 1);
    const glm::dmat4 clip = view.world_to_clip() * from_anchor;
    for (int c = 0; c < 4; ++c) {
        s.to_x[c] = float((clip[c][0] + clip[c][3]) * (0.5 * size.x));
        s.to_y[c] = float((clip[c][1] + clip[c][3]) * (0.5 * size.y));
    }
    for (int c = 0; c < 3; ++c) s.anchor[c] = anchor[c], s.forward[c] = float(view.forward[c]);
    const glm::dvec3 off = glm::dvec3(anchor) - view.eye;
    s.forward[3] = float(view.forward.x * off.x + view.forward.y * off.y + view.forward.z * off.z);
    s.width = size.x, s.height = size.y;
    s.least_depth = 1e-6f;
    s.perspective = view.orthographic ? 0.0f : 1.0f;
    return s;
}

Buffer<float> half_ball(const AoParams& params) {
    Buffer<float> samples;
    for (int i = 0; i < params.samples; ++i) {
        const double share = double(i) / params.samples, distance = 0.1 + 0.9 * share * share;
        glm::dvec3 d;
        if (params.variant == AoVariant::published) {
            const glm::dvec3 v = of_cube(i, false, seed_of_samples);
            d = v / std::sqrt(std::max(v.x * v.x + v.y * v.y + v.z * v.z, 1e-30));
        } else {
            d = sample_hemisphere(r2(std::uint64_t(i)));
        }
        for (const double c : {d.x * distance, d.y * distance, d.z * distance, 0.0}) samples.push_back(float(c));
    }
    return samples;
}

Buffer<float> rotations(const AoParams& params) {
    Buffer<float> turns;
    for (int i = 0; i < rotation_count; ++i) {
        glm::dvec2 v(of_cube(i, true, seed_of_rotations));
        if (params.variant == AoVariant::corrected) {
            const double angle = 2 * host::pi * van_der_corput(std::uint64_t(i));
            v = {host::cos(angle), host::sin(angle)};
        }
        turns.push_back(float(v.x)), turns.push_back(float(v.y));
    }
    return turns;
}

StageData data_of(const AoParams& params, const SsaoInputs& in) {
    validate(params);
    const glm::ivec2 size = size_of(bound("screen.ssao", "position", in.position));
    const bool weighted = params.views == AoViews::lights, published = params.variant == AoVariant::published;
    StageData d = begin_data<SsaoKernel>(
        size, SsaoUniforms{seen_from(in.view, size_of(bound("screen.ssao", "map_position", in.seen))), params.radius, params.bias,
                           params.weight_bias, params.samples, in.own, weighted, published, size.x, size.y, {}});
    lend(d, {{"position", in.position}, {"normal", in.normal}, {"map_position", in.seen}});
    if (in.before) lend(d, {{"before", in.before}});
    const Buffer<float> samples = half_ball(params), turns = rotations(params);
    add(d.inputs, "samples", {params.samples, 4}, samples.data());
    add(d.inputs, "rotations", {rotation_count, 2}, turns.data());
    lend_tiles(d, in.tiles);
    return d;
}

}  // namespace plumb::screen
