#include "gi/screen/reuse.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "gi/run_two.h"
#include "gi/screen/ssao.h"

namespace plumb::screen {

namespace {

constexpr float least_weight = 1.0f / 64;

const Image4& nothing() {
    static const Image4 image(1, 1);
    return image;
}

// How the picks of a picture of `frame` pixels are seen: `size` is half of it, or all.
SeenFrom picks_seen(const View& view, glm::ivec2 size, glm::ivec2 frame) {
    SeenFrom seen = seen_from(view, size);
    if (frame == glm::ivec2(0) || frame == size) return seen;
    // An odd picture's half is rounded up; its pixels are not.
    for (int c = 0; c < 4; ++c) {
        seen.to_x[c] = float(double(seen.to_x[c]) * 0.5 * frame.x / size.x);
        seen.to_y[c] = float(double(seen.to_y[c]) * 0.5 * frame.y / size.y);
    }
    return seen;
}

}  // namespace

StageData data_of(const ReuseParams& params, const ReuseInputs& in) {
    validate(params);
    const char* name = "screen.reuse";
    const glm::ivec2 size = size_of(bound(name, "irradiance", in.irradiance));
    const bool there = in.last && !in.last->empty();
    const auto image = [&](const Image4 LastFrame::*of) { return there ? &(in.last->*of) : &nothing(); };
    const glm::ivec2 last = size_of(*image(&LastFrame::irradiance));
    ReuseUniforms u{};
    if (there) u.last = picks_seen(in.last->view, last, in.last->frame), u.now = picks_seen(in.view, size, in.frame);
    u.last.width = last.x, u.last.height = last.y;
    u.most = float(std::max(params.frames, 1)), u.least_weight = least_weight;
    u.sigma_depth = params.sigma_depth, u.normal_slope = 1 / params.sigma_normal, u.normal_offset = 1 - 1 / params.sigma_normal;
    u.clamps = params.clamp == ReuseClamp::box, u.there = there, u.width = size.x, u.height = size.y;
    StageData d = begin_data<ReuseKernel>(size, u);
    lend(d, {{"irradiance", in.irradiance}, {"position", in.position}, {"normal", in.normal},
             {"last_irradiance", image(&LastFrame::irradiance)}, {"last_age", image(&LastFrame::age)},
             {"last_position", image(&LastFrame::position)}, {"last_normal", image(&LastFrame::normal)}});
    return d;
}

void run_reuse(const ReuseParams& params, const ReuseInputs& in, const RunOptions& options, Image4& light, Image4& age) {
    run_two(stage<ReuseKernel>(), data_of(params, in), options, light, age);
}

int turn_of_frame(std::uint32_t frame, int rotations) {
    int step = std::max(1, int(std::lround(0.6180339887498949 * rotations)));
    while (std::gcd(step, rotations) != 1) ++step;
    return int(std::uint64_t(frame) * std::uint64_t(step) % std::uint64_t(rotations));
}

}  // namespace plumb::screen
