// The stages filter.reduce, filter.upsample and filter.blur: irradiance that was gathered at half size, or with noise,
// becomes irradiance of every pixel (VRSM 4.4, 4.5, fig. 4.4). They know nothing of what gathered it. See
// gi/filter/README.md.
#pragma once

#include <vector>

#include "core/image.h"
#include "core/isa.h"
#include "core/stage.h"
#include "core/tap.h"
#include "gi/filter/upsample_kernel.h"
#include "raster/covered.h"

namespace plumb::filter {

enum class Resolution : int { full, half };
enum class Blur : int { none, full, separable };

// How a frame filters its indirect light: the table [indirect] of a scene file.
struct FilterParams {
    Resolution resolution = Resolution::full;
    Upsample upsample = Upsample::bilateral;
    Blur blur = Blur::none;
    int kernel = 17;
    float sigma_distance = 3;
    Similarity similarity = Similarity::plane;
    float sigma_depth = 0.02f;
    float sigma_normal = 0.3f;
};
std::vector<Field> fields(FilterParams& params);

// Size of the half-size image: rounded up.
inline glm::ivec2 half_size(glm::ivec2 size) { return (size + 1) / 2; }

// One pixel of every 2 x 2: (min(2 x + 1, w - 1), min(2 y + 1, h - 1)).
void run_reduce(const Image4& image, const RunOptions& options, Image4& reduced);

struct UpsampleInputs {
    const Image4* coarse_irradiance = nullptr;  // half-size; xyz W/m2, w linear depth, m
    const Image4* coarse_position = nullptr;    // half-size; xyz world, m
    const Image4* coarse_normal = nullptr;      // half-size; xyz unit, all 0 where there is no surface
    const Image4* position = nullptr;           // xyz world, m, w linear depth, m
    const Image4* normal = nullptr;
    const raster::Covered* tiles = nullptr;     // the others get 0; null: all are computed
};
// upsampled: xyz W/m2, 0 where no surface is; w the linear depth of `position`.
void run(const FilterParams& params, const UpsampleInputs& inputs, const RunOptions& options, Image4& upsampled);

enum class Direction : int { both, horizontal, vertical };

struct BlurInputs {
    const Image4* irradiance = nullptr;  // xyz W/m2, w linear depth, m
    const Image4* position = nullptr;    // xyz world, m
    const Image4* normal = nullptr;      // xyz unit, all 0 where there is no surface
    Direction direction = Direction::both;
    const raster::Covered* tiles = nullptr;
};
// One dispatch: of kernel x kernel pixels, or of one row or column of them. params.blur is not read.
void run(const FilterParams& params, const BlurInputs& inputs, const RunOptions& options, Image4& blurred);

// The blur of params.blur: nothing, one dispatch, or two.
void run_blur(const FilterParams& params, const BlurInputs& inputs, const RunOptions& options, Image4& blurred);

// exp(-(dx^2 + dy^2) / (2 sigma^2)), [2 radius_y + 1][2 radius_x + 1], made in double precision; 0 in the middle, whose
// weight the kernel knows.
Buffer<float> spatial_weights(const FilterParams& params, Direction direction);

std::vector<TapValue> explain_reduce(const Image4& image, glm::ivec2 pixel);
std::vector<TapValue> explain(const FilterParams& params, const UpsampleInputs& inputs, glm::ivec2 pixel);
std::vector<TapValue> explain(const FilterParams& params, const BlurInputs& inputs, glm::ivec2 pixel);

StageInfo info_reduce();
StageInfo info_upsample();
StageInfo info_blur();

}  // namespace plumb::filter
