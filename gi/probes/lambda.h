// probes.lambda: what probes see, as coefficients of harmonics.
#pragma once

#include <array>

#include "core/binding.h"
#include "core/stage_description.h"
#include "gi/probes/lambda_kernel.h"

namespace plumb::probes {

inline constexpr int most_lambda_levels = 4, most_lambda_probes = 32767;

struct LambdaInputs {
    using Kernel = LambdaKernel;
    int probes = 0, rays = 0, coefficients = 0;       // at level 0; coefficients: (degree + 1)^2
    int levels = 1;
    std::array<int, most_lambda_levels> level_rays{};          // of each level: the first
    std::array<int, most_lambda_levels> level_coefficients{};
    const Buffer<glm::vec4>* radiance = nullptr;      // [probes][rays]: W/(m2 sr)
    const Buffer<float>* harmonics = nullptr;         // [rays][coefficients]: harmonics_of(), or windowed
    const Buffer<float>* weights = nullptr;           // [levels][rays]: level_weights(), sr
    const std::vector<std::int32_t>* probe_level = nullptr;  // [probes]
};

// relight_weights() of each level's first rays, 0 beyond them: [levels][directions]. Throws InputError for a number of rays that is
// not 1 to all.
Buffer<float> level_weights(const Buffer<glm::vec4>& directions, const std::vector<int>& level_rays);

// Refuses levels that there are not. Throws InputError.
void check_lambda(LambdaView& view, Buffer<float>& own);
// What of a level is more than there is, or nothing.
std::string refused_level(const LambdaUniforms& u);

inline StageDescription<LambdaView> describe(LambdaKernel) {
    using View = LambdaView;
    return {
        .name = "probes.lambda",
        .source = "IPR 3.3.1.1, (10); levels of detail: IPR 4.2.1",
        .domain = "coefficient of a probe",
        .inputs = {{.name = "radiance", .at = &View::radiance, .unit = "W/(m2 sr)", .meaning = "[probe][ray] f; w unused", .fixed = 8,
                    .count = [](const View& v) { return std::size_t(v.u.height) * std::size_t(v.u.rays); }, .why = "rays of each probe"},
                   {.name = "harmonics", .at = &View::harmonics, .meaning = "[ray][coefficient] Y_j, windowed or not",
                    .count = [](const View& v) { return std::size_t(v.u.rays) * std::size_t(v.u.width); },
                    .why = "coefficients of each ray"},
                   {.name = "weights", .at = &View::weights, .unit = "sr", .meaning = "[level][ray] w_r",
                    .count = [](const View& v) { return std::size_t(v.u.levels) * std::size_t(v.u.rays); }, .why = "rays of each level"},
                   {.name = "probe_level", .at = &View::probe_level, .meaning = "[probe] level of detail",
                    .count = [](const View& v) { return std::size_t(v.u.height); }, .why = "one a probe"}},
        .outputs = {{.name = "lambda", .at = &View::lambda, .unit = "W/(m2 sr^(1/2))", .meaning = "[probe][coefficient] lambda_ij; w 0"}},
        .uniforms = {{"width", 1, sh::kernel_degrees * sh::kernel_degrees}, {"rays", 1, 1 << 15}, {"levels", 1, most_lambda_levels}},
        .refuses = [](const View& v, glm::ivec2) { return refused_level(v.u); },
        .prepare = check_lambda,
        .cost = {0.1, "probes x coefficients x rays"},
    };
}
StageData data_of(const LambdaInputs& in);

// lambda of each probe: [probes][coefficients], w 0.
void run(const LambdaInputs& in, const RunOptions& options, Buffer<glm::vec4>& lambda);

}  // namespace plumb::probes
