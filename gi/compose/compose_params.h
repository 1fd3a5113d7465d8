// The parameters of composition and tone mapping: the tables [compose] and [tonemap] of a scene file.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "core/fields.h"
#include "gi/compose/tonemap_kernel.h"

namespace plumb::compose {

struct ComposeParams {
    glm::vec3 shadow_color{0};  // W/(m2 sr)
};
std::vector<Field> fields(ComposeParams& params);
// Whether the shadow density is read: not by a black shadow colour.
inline bool reads_density(const ComposeParams& params) { return params.shadow_color != glm::vec3(0); }

struct TonemapParams {
    Operator op = Operator::exposure;
    float exposure = 1;
    float dimmer = 1;
    float contrast = 1;
    float gamma = 0;  // 0: the curve of sRGB
};
std::vector<Field> fields(TonemapParams& params);
// Throws InputError that names the parameter.
void validate(const TonemapParams& params);

}  // namespace plumb::compose
