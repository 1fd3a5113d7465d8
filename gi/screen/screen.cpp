#include "gi/screen/screen.h"

#include <cmath>

#include "core/host_math.h"
#include "core/sequences.h"
#include "gi/filter/filter_params.h"

namespace plumb::screen {

Buffer<float> slice_turns(const AoParams& params) {
    Buffer<float> turns;
    for (int r = 0; r < rotation_count; ++r)
        for (int i = 0; i < params.slices; ++i) {
            const double angle = host::pi * (i + van_der_corput(std::uint64_t(r))) / params.slices;
            turns.push_back(float(host::cos(angle))), turns.push_back(float(host::sin(angle)));
        }
    return turns;
}

Buffer<float> step_shares(const AoParams& params) {
    Buffer<float> shares;
    for (int k = 0; k < params.steps; ++k) {
        const double share = (k + 0.5) / params.steps;
        shares.push_back(float(share * share));
    }
    return shares;
}

StageData data_of(const AoParams& params, const HorizonInputs& in) {
    validate(params);
    const glm::ivec2 size = size_of(bound("screen.horizon", "position", in.position));
    HorizonUniforms u{};
    const SeenFrom seen = seen_from(in.view, size);
    for (int c = 0; c < 4; ++c) u.anchor[c] = seen.anchor[c], u.forward[c] = seen.forward[c];
    u.anchor[3] = seen.least_depth;
    const glm::dmat4 clip = in.view.world_to_clip();
    auto axis = [&](int row, double pixels, float* out) {
        // The clip row without what the view adds along its axis.
        glm::dvec3 a(clip[0][row], clip[1][row], clip[2][row]);
        a = a - in.view.forward * (a.x * in.view.forward.x + a.y * in.view.forward.y + a.z * in.view.forward.z);
        const double length = std::sqrt(a.x * a.x + a.y * a.y + a.z * a.z);
        for (int c = 0; c < 3; ++c) out[c] = float(a[c] / length);
        out[3] = float(length * 0.5 * pixels);
    };
    axis(0, size.x, u.right), axis(1, size.y, u.down);
    u.radius = params.radius, u.bias = params.bias, u.slices = params.slices, u.steps = params.steps, u.width = size.x, u.height = size.y;
    StageData d = begin_data<HorizonKernel>(size, u);
    lend(d, {{"position", in.position}, {"normal", in.normal}});
    const Buffer<float> turns = slice_turns(params), shares = step_shares(params);
    add(d.inputs, "turns", {rotation_count * params.slices, 2}, turns.data());
    add(d.inputs, "shares", {params.steps}, shares.data());
    lend_tiles(d, in.tiles);
    return d;
}

StageData data_of(const AoParams& params, const BlurInputs& in) {
    validate(params);
    const glm::ivec2 size = size_of(bound("screen.blur", "summed", in.summed));
    const filter::FilterParams edges;
    const bool published = params.variant == AoVariant::published, none = params.blur == AoBlur::none;
    BlurUniforms u{size.x, size.y, none ? 0 : -2, none ? 0 : published ? 1 : 2, published, params.blur == AoBlur::edge_aware,
                   edges.sigma_depth, 1 / edges.sigma_normal, 1 - 1 / edges.sigma_normal, {}};
    StageData d = begin_data<BlurKernel>(size, u);
    lend(d, {{"summed", in.summed}, {"position", in.position}, {"normal", in.normal}});
    lend_tiles(d, in.tiles);
    return d;
}

StageData data_of(const AoParams& params, const OccludeInputs& in) {
    validate(params);
    const glm::ivec2 size = size_of(bound("screen.occlude", "indirect", in.indirect));
    const glm::vec3 a = params.ambient;
    StageData d = begin_data<OccludeKernel>(size, OccludeUniforms{{a.x, a.y, a.z, 0}, size.x, size.y, {}});
    lend(d, {{"indirect", in.indirect}, {"open", in.open}});
    return d;
}

}  // namespace plumb::screen
