// The parameters of direct light and of shadows: the tables [direct] and [shadow] of a scene file.
#pragma once

#include <vector>

#include "core/fields.h"

namespace plumb::direct {

enum class ShadowMode : int { hard, density, pcf, esm };
enum class ShadowVariant : int { corrected, published };
enum class ShadowTest : int { depth, plane, planes };
enum class VisibilityFilter : int { none, gaussian, edge_aware };

struct ShadowParams {
    ShadowMode mode = ShadowMode::pcf;
    ShadowVariant variant = ShadowVariant::corrected;
    int kernel = 4;
    int pcf_kernel = 1;
    ShadowTest test = ShadowTest::planes;
    float least_sine = 0.1f;
    float bias = 0.001f;
    float slope_bias = 1;
    float max_slope = 16;
    float esm_c = 90;
    int esm_blur_radius = 3;
    float esm_blur_sigma = 1.5f;
    VisibilityFilter filter = VisibilityFilter::none;
    int filter_radius = 4;
    float filter_sigma = 2;
    float filter_sigma_depth = 0.02f;
    float filter_sigma_normal = 0.3f;
};
std::vector<Field> fields(ShadowParams& params);

enum class DirectVariant : int { corrected, published };

struct DirectParams {
    DirectVariant variant = DirectVariant::corrected;
};
std::vector<Field> fields(DirectParams& params);

}  // namespace plumb::direct
