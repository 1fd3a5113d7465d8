// Data for the stages that relight probes: radiance of rays, coefficients of probes.
#pragma once

#include <vector>

#include "gi/probes/lambda.h"
#include "gi/probes/radiance.h"
#include "tests/parity/twin_data_parts.h"

namespace plumb::test {

// A lightmap of odd levels; places between its texels and beyond its edge; every fifth ray met nothing that reflects.
inline StageData radiance_case(glm::ivec2 size, probes::Feedback feedback, int levels, const std::string& id) {
    const int rays = size.x * size.y;
    const auto list = [&](std::uint32_t seed, float low, float high) {
        return noise_image({size.x, size.y}, seed, low, high).texels;
    };
    Buffer<glm::vec4> surface = list(101, 0, 1), place = list(104, -0.05f, 1.05f);
    const Buffer<glm::vec4> emitted = list(102, 0, 2), direct = list(103, 0, 9);
    for (int i = 0; i < rays; ++i) {
        surface[std::size_t(i)].w = i % 5 == 3 ? 0 : 1;
        place[std::size_t(i)].z = float(i % levels);
    }
    const int side = 13;
    const Image4 lightmap = noise_image({side, probes::lightmap_rows(side, levels)}, 105, 0, 7);
    probes::RadianceInputs in;
    in.probes = size.y, in.rays = size.x, in.feedback = feedback, in.side = side, in.levels = levels;
    in.surface = &surface, in.emitted = &emitted, in.direct = &direct, in.place = &place, in.lightmap = &lightmap;
    return named(owned_data(probes::data_of(in)), id);
}

// Levels of a whole part of the sum and three more rays, of a part, of five and of one; rays and harmonics behind a level's are
// there, too.
inline StageData lambda_case(glm::ivec2 size, int levels, const std::string& id) {
    const int rays = 131, width = std::min(size.x, 64);
    Buffer<glm::vec4> radiance = noise_image({rays, size.y}, 106, -0.5f, 3).texels;
    Buffer<float> harmonics, weights;
    std::vector<std::int32_t> level;
    for (int i = 0; i < rays * width; ++i) harmonics.push_back(2 * noise(i, 0, 0, 107) - 1);
    for (int i = 0; i < rays * levels; ++i) weights.push_back(0.02f + 0.1f * noise(i, 0, 0, 108));
    for (int i = 0; i < size.y; ++i) level.push_back((3 * i + 1) % levels);
    probes::LambdaInputs in;
    in.probes = size.y, in.rays = rays, in.coefficients = width, in.levels = levels;
    in.level_rays = {rays, 128, 5, 1};
    in.level_coefficients = {width, std::max(1, width - 1), std::max(1, width / 2), 1};
    in.radiance = &radiance, in.harmonics = &harmonics, in.weights = &weights, in.probe_level = &level;
    return named(owned_data(probes::data_of(in)), id);
}

inline std::vector<StageData> relight_cases(glm::ivec2 size) {
    using probes::Feedback;
    return {
        radiance_case(size, Feedback::corrected, 4, "probes.radiance"),
        radiance_case(size, Feedback::constant, 1, "probes.radiance.constant"),
        radiance_case(size, Feedback::material, 3, "probes.radiance.material"),
        lambda_case(size, 4, "probes.lambda"),
        lambda_case(size, 1, "probes.lambda.one_level"),
    };
}

}  // namespace plumb::test
