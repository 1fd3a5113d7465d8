#include "gi/probes/run_loop.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "gi/lend.h"

namespace plumb::probes {

RadianceInputs radiance_inputs(const UpdateBuffers& b) {
    RadianceInputs in;
    in.probes = b.surface->height, in.rays = b.surface->width;
    in.feedback = b.feedback, in.constant = b.constant;
    in.side = b.data->lightmap_size.x, in.levels = b.data->levels;
    in.surface = &b.surface->texels, in.emitted = &b.emitted->texels, in.direct = &b.direct->texels, in.place = &b.place->texels;
    in.lightmap = b.last_lightmap;
    return in;
}

LambdaInputs lambda_inputs(const UpdateBuffers& b) {
    LambdaInputs in;
    in.probes = b.data->probes, in.rays = b.data->rays, in.coefficients = b.data->coefficients;
    in.levels = b.counts.levels, in.level_rays = b.counts.rays, in.level_coefficients = b.counts.coefficients;
    in.radiance = &b.radiance->texels, in.harmonics = b.harmonics, in.weights = b.weights, in.probe_level = b.probe_level;
    return in;
}

BasisInputs basis_inputs(const UpdateBuffers& b) {
    BasisInputs in;
    in.clusters = b.data, in.cluster_level = (b.basis_level ? b.basis_level : b.cluster_level)->data(), in.lambda = b.read_lambda->data(), in.probes = b.data->probes;
    in.coefficients = glm::ivec4(0);
    for (int k = 0; k < b.counts.levels; ++k) in.coefficients[k] = b.counts.coefficients[std::size_t(k)];
    return in;
}

IrradianceInputs irradiance_inputs(const UpdateBuffers& b) {
    IrradianceInputs in;
    in.clusters = b.data, in.cluster_level = b.cluster_level->data(), in.receiver_level = b.data->receiver_level.data();
    in.basis = b.read_basis->data();
    return in;
}

LightmapInputs lightmap_inputs(const UpdateBuffers& b) {
    LightmapInputs in;
    in.cover = &b.data->cover, in.irradiance = b.irradiance->data(), in.places = b.data->count();
    return in;
}

namespace {

template <class Inputs>
void run_stage(const Inputs& in, const RunOptions& options, Image4& out) {
    plumb::run(stage<typename Inputs::Kernel>(), data_of(in), options, out);
}

}  // namespace

void update(const UpdateBuffers& b, const RunOptions& options) {
    run_stage(radiance_inputs(b), options, *b.radiance);
    run_stage(lambda_inputs(b), options, *b.lambda);
    run_stage(basis_inputs(b), options, *b.basis);
    run_stage(irradiance_inputs(b), options, *b.irradiance);
    if (b.tiles)
        write_lightmap(lightmap_inputs(b), options, *b.tiles, *b.lightmap);
    else
        run_stage(lightmap_inputs(b), options, *b.lightmap);
}

namespace {

constexpr double of_rounding = 1e-4;  // of the sum: a smaller step says nothing of the gain
constexpr int growing_rounds = 8;  // in a row, until light is said to grow: its first bounces may

// Sums over places and channels, in their order.
struct Step {
    double sum = 0, change = 0;
};
Step step_of(const Image4& now, const Image4& last, int places) {
    Step s;
    for (std::size_t i = 0; i < std::size_t(places); ++i)
        for (int c = 0; c < 3; ++c) {
            const double x = now.texels[i][c];
            s.sum += std::fabs(x), s.change += std::fabs(x - double(last.texels[i][c]));
        }
    return s;
}

std::string rounds_text(int rounds) { return fmt::format("{} round{}", rounds, rounds == 1 ? "" : "s"); }

[[noreturn]] void refuse(const RunParams& p, int round, double gain) {
    const std::string by = p.feedback == Feedback::corrected  ? "surfaces reflect more than they get"
                           : p.feedback == Feedback::constant ? fmt::format("feedback = constant, reflection = {:g}: a closed scene takes less than 1/pi", p.reflection)
                                                              : "feedback = material: the published product of reflectance and irradiance lacks 1/pi";
    throw InputError(fmt::format("probes: after {} light still grows, {:.4g} times a round: {}", rounds_text(round), gain, by));
}

}  // namespace

Convergence converge(UpdateBuffers b, const RunParams& params, const RunOptions& options, Image4& before) {
    const glm::ivec2 size = b.data->lightmap_size;
    before = Image4(size.x, size.y);
    b.last_lightmap = &before, b.read_lambda = b.lambda, b.read_basis = b.basis;
    Convergence c;
    Image4 last;
    double before_step = 0;
    for (int growing = 0; c.rounds < params.rounds;) {
        if (c.rounds > 0) std::swap(before, *b.lightmap);
        update(b, options);
        ++c.rounds;
        if (last.empty()) last = Image4(b.irradiance->width, b.irradiance->height);
        const Step s = step_of(*b.irradiance, last, b.data->count());
        if (!std::isfinite(s.sum)) throw InputError(fmt::format("probes: after {} light is not finite", rounds_text(c.rounds)));
        if (c.rounds > 1 && s.change > of_rounding * s.sum) c.gain = s.change / before_step;
        c.left = s.change == 0 ? 0 : c.rounds > 1 && c.gain < 1 ? s.change * c.gain / (1 - c.gain) / s.sum : std::numeric_limits<double>::infinity();
        growing = c.rounds > 1 && c.gain >= 1 ? growing + 1 : 0;
        if (growing >= growing_rounds) refuse(params, c.rounds, c.gain);
        if (s.change == 0 || (c.rounds > 1 && c.left <= double(params.tolerance))) break;
        before_step = s.change;
        last = *b.irradiance;
    }
    c.negative = negative_irradiance(b.irradiance->texels);
    return c;
}

std::string text_of(const Convergence& c) {
    std::string text = c.rounds == 1 && c.left > 0 ? "1 round: what others add is not known"
                                                   : fmt::format("{}, gain {:.3f}, {:.2g} % left", rounds_text(c.rounds), c.gain, 100 * c.left);
    const NegativeIrradiance& n = c.negative;
    if (n.negative > 0)
        text += fmt::format(", irradiance below 0 at {} of {} receivers, {:.2g} W/m2 at least", n.negative, n.computed, double(n.least));
    return text;
}

}  // namespace plumb::probes
