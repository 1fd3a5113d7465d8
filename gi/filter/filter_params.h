// How a frame filters its indirect light: the table [indirect] of a scene file.
#pragma once

#include <vector>

#include "core/binding.h"
#include "gi/filter/upsample_kernel.h"

namespace plumb::filter {

enum class Resolution : int { full, half };
enum class Blur : int { automatic, none, full, separable };

struct FilterParams {
    Resolution resolution = Resolution::full;
    Upsample upsample = Upsample::bilateral;
    Blur blur = Blur::automatic;
    int kernel = 17;
    float sigma_distance = 3;
    Similarity similarity = Similarity::plane;
    float sigma_depth = 0.02f;
    float sigma_normal = 0.3f;
};
std::vector<Field> fields(FilterParams& params);
std::vector<ParamInfo> params_of(const std::vector<std::string>& names);

// Size of the half-size image: rounded up.
inline glm::ivec2 half_size(glm::ivec2 size) { return (size + 1) / 2; }
// Says what is wrong with `half` as the half of `full`, or nothing.
std::string refuse_half(glm::ivec2 full, glm::ivec2 half);

}  // namespace plumb::filter
