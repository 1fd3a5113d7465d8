// The stages shadow and direct: which lights a point sees, and the irradiance they send. See gi/direct/README.md.
#pragma once

#include <span>
#include <vector>

#include "core/image.h"
#include "core/isa.h"
#include "core/scene.h"
#include "core/stage.h"
#include "core/tap.h"
#include "raster/covered.h"
#include "raster/rsm.h"

namespace plumb::direct {

enum class ShadowMode : int { hard, density, pcf, esm };
enum class ShadowVariant : int { corrected, published };

struct ShadowParams {
    ShadowMode mode = ShadowMode::hard;
    ShadowVariant variant = ShadowVariant::corrected;
    int kernel = 4;
    float bias = 0.001f;
    float slope_bias = 1;
    float max_slope = 16;
    float esm_c = 90;
    int esm_blur_radius = 3;
    float esm_blur_sigma = 1.5f;
};
std::vector<Field> fields(ShadowParams& params);

struct ShadowInputs {
    const Image4* position = nullptr;  // xyz world, m
    const Image4* normal = nullptr;    // xyz unit; all 0 where nothing is
    std::span<const raster::Rsm> rsms; // the light's map, or the six of a point light; position.w is the depth map
    const raster::Covered* tiles = nullptr;  // the others, which must see nothing, are not shaded; null: all are
    std::span<const Image4> blurred = {};    // of mode = esm: read instead of the maps' own depths (log_blur.h)
};
// visibility: [height][width] floats, 1 lit, 0 shadowed. What a face of size 0 would serve is lit. Where nothing is seen,
// position and normal are 0, and so the visibility is one number all over: that of the world's origin.
void run(const ShadowParams& params, const ShadowInputs& inputs, const RunOptions& options, float* visibility);
std::vector<TapValue> explain(const ShadowParams& params, const ShadowInputs& inputs, glm::ivec2 pixel);
StageInfo shadow_info();

enum class DirectVariant : int { corrected, published };

struct DirectParams {
    DirectVariant variant = DirectVariant::corrected;
};
std::vector<Field> fields(DirectParams& params);

struct DirectInputs {
    const Image4* position = nullptr;
    const Image4* normal = nullptr;  // w: 1 on a surface; all 0 where nothing is
    const std::vector<Light>* lights = nullptr;
    const Buffer<float>* visibility = nullptr;  // [lights][height][width]
    const raster::Covered* tiles = nullptr;     // the others keep 0 throughout; null: all are shaded
    bool density = false;                       // whether the shadow density is asked for; published has it always
};
// irradiance: W/m2 in xyz; w the shadow density (VRSM 4.3, fig. 4.3), 0 where it is not asked for.
void run(const DirectParams& params, const DirectInputs& inputs, const RunOptions& options, Image4& irradiance);
std::vector<TapValue> explain(const DirectParams& params, const DirectInputs& inputs, glm::ivec2 pixel);
StageInfo direct_info();

}  // namespace plumb::direct
