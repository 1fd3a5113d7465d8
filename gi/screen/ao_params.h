// The parameters of ambient occlusion: the table [ao] of a scene file. See gi/screen/README.md.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "core/fields.h"
#include "core/stage.h"

namespace plumb::screen {

enum class AoMethod : int { off, ssao, horizon };
enum class AoVariant : int { corrected, published };
enum class AoViews : int { camera, lights };
enum class AoBlur : int { none, box, edge_aware };

inline constexpr int most_samples = 1024, most_slices = 64, most_steps = 256;

// fields() says what each means.
struct AoParams {
    AoMethod method = AoMethod::off;
    AoVariant variant = AoVariant::corrected;
    float radius = 0.5f;
    float bias = 0.01f;
    int samples = 64;
    AoViews views = AoViews::camera;
    float weight_bias = 0.25f;
    int slices = 4;
    int steps = 8;
    AoBlur blur = AoBlur::edge_aware;
    glm::vec3 ambient{0};
};
std::vector<Field> fields(AoParams& params);
std::vector<ParamInfo> params_of(const std::vector<std::string>& names);

// Throws InputError that names the parameter: what no range of one says.
void validate(const AoParams& params);

}  // namespace plumb::screen
