#include "gi/probes/lambda.h"

#include "gi/lend.h"
#include "gi/probes/directions.h"

namespace plumb::probes {

namespace {

template <class List>
const List& listed(const char* name, const List* list, std::int64_t count) {
    if (!list || std::int64_t(list->size()) != count)
        throw InputError(fmt::format("probes.lambda: {}: {} of them: expected {}", name, list ? list->size() : 0, count));
    return *list;
}

}  // namespace

Buffer<float> level_weights(const Buffer<glm::vec4>& directions, const std::vector<int>& level_rays) {
    Buffer<float> weights(level_rays.size() * directions.size(), 0.0f);
    for (std::size_t level = 0; level < level_rays.size(); ++level) {
        const int n = level_rays[level];
        if (n < 1 || std::size_t(n) > directions.size())
            throw InputError(fmt::format("{} rays at level {}: expected 1 to {}", n, level, directions.size()));
        const Buffer<float> of_level = relight_weights(directions, n);
        std::copy(of_level.begin(), of_level.end(), weights.begin() + std::ptrdiff_t(level * directions.size()));
    }
    return weights;
}

std::string refused_level(const LambdaUniforms& u) {
    const int rays[] = {u.rays_0, u.rays_1, u.rays_2, u.rays_3};
    const int coefficients[] = {u.coefficients_0, u.coefficients_1, u.coefficients_2, u.coefficients_3};
    for (int level = 0; level < u.levels; ++level) {
        if (rays[level] < 1 || rays[level] > u.rays)
            return fmt::format("rays_{} is {}: expected 1 to {}", level, rays[level], u.rays);
        if (coefficients[level] < 1 || coefficients[level] > u.width)
            return fmt::format("coefficients_{} is {}: expected 1 to {}", level, coefficients[level], u.width);
    }
    return {};
}

void check_lambda(LambdaView& v, Buffer<float>&) {
    for (int p = 0; p < v.u.height; ++p)
        if (const int level = v.probe_level[p]; level < 0 || level >= v.u.levels)
            throw InputError(fmt::format("probes.lambda: probe_level: number {} is {}: expected 0 to {}", p, level, v.u.levels - 1));
}

StageData data_of(const LambdaInputs& in) {
    if (in.probes < 1 || in.rays < 1 || in.coefficients < 1)
        throw InputError(fmt::format("probes.lambda: {} coefficients of {} rays of {} probes: expected 1 or more", in.coefficients,
                                     in.rays, in.probes));
    const auto &n = in.level_rays, &c = in.level_coefficients;
    const LambdaUniforms u{in.coefficients, in.probes, in.rays, in.levels, n[0], n[1], n[2], n[3], c[0], c[1], c[2], c[3]};
    StageData d = begin_data<LambdaKernel>({u.width, u.height}, u);
    const std::int64_t probes = in.probes, rays = in.rays, coefficients = in.coefficients;
    lend(d.inputs, "radiance", {probes * rays, 4}, &listed("radiance", in.radiance, probes * rays)[0].x);
    lend(d.inputs, "harmonics", {rays * coefficients}, listed("harmonics", in.harmonics, rays * coefficients).data());
    lend(d.inputs, "weights", {in.levels * rays}, listed("weights", in.weights, in.levels * rays).data());
    lend(d.inputs, "probe_level", {probes}, listed("probe_level", in.probe_level, probes).data());
    return d;
}

void run(const LambdaInputs& in, const RunOptions& options, Buffer<glm::vec4>& lambda) {
    const StageData data = data_of(in);
    lambda.resize(std::size_t(in.probes) * std::size_t(in.coefficients));
    run(stage<LambdaKernel>(), data, options, &lambda[0].x);
}

}  // namespace plumb::probes
