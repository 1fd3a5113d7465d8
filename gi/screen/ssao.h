// screen.ssao: ambient occlusion from one view, added to what other views see (LRA 4.2.3, 4.3.2).
#pragma once

#include "core/binding.h"
#include "core/stage_description.h"
#include "core/view.h"
#include "gi/screen/ao_params.h"
#include "gi/screen/ssao_kernel.h"
#include "raster/covered.h"

namespace plumb::screen {

struct SsaoInputs {
    using Kernel = SsaoKernel;
    const Image4* position = nullptr;  // of the receivers
    const Image4* normal = nullptr;
    const Image4* seen = nullptr;      // of the view: its positions, w linear depth
    View view;
    bool own = false;                  // the view is the receivers'
    const Image4* before = nullptr;    // what other views have summed; null: nothing
    const raster::Covered* tiles = nullptr;
};

inline StageDescription<SsaoInputsView> describe(SsaoKernel) {
    using View = SsaoInputsView;
    return {
        .name = "screen.ssao",
        .source = "LRA 4.2.3, 6.2.3 (ambient occlusion), 4.3.2, 6.3.2 (from several views)",
        .domain = "pixel",
        .inputs = {{.name = "position", .at = &View::position, .unit = "m", .meaning = "world-space position"},
                   {.name = "normal", .at = &View::normal, .meaning = "unit normal; all 0 where nothing is"},
                   {.name = "map_position", .at = &View::map_position, .unit = "m",
                    .meaning = "of the view: xyz world-space position, w linear depth; 0 where nothing is",
                    .size = [](const View& v) { return glm::ivec2(v.u.view.width, v.u.view.height); },
                    .why = "as view.width and view.height say"},
                   {.name = "before", .at = &View::before, .meaning = "what other views have summed", .optional = true},
                   {.name = "samples", .at = &View::samples, .meaning = "xyz in the half ball of radius 1 about +z",
                    .count = [](const View& v) { return std::size_t(v.u.samples); }, .why = "a vec4 a sample"},
                   {.name = "rotations", .at = &View::rotations, .meaning = "cosine and sine of each pixel of 4 x 4",
                    .count = [](const View&) { return std::size_t(rotation_count); }, .why = "a vec2 a rotation"}},
        .outputs = {{.name = "summed", .at = &View::summed,
                     .meaning = "sum w o; sum w; o of the receivers' own view; 1 on a surface", .fixed = 8}},
        .params = params_of({"method", "variant", "radius", "bias", "samples", "views", "weight_bias"}),
        .uniforms = {{"samples", 1, most_samples}, {"view.width", 1, 32767}, {"view.height", 1, 32767},
                     {"own", 0, 1}, {"weighted", 0, 1}, {"published", 0, 1}},
        .fixed_uniforms = {{"view.perspective", 1}},
        .cost = {2, "samples"},
    };
}

StageData data_of(const AoParams& params, const SsaoInputs& in);

// How kernels project into the image of `size` texels through which the view sees.
SeenFrom seen_from(const View& view, glm::ivec2 size);

// Samples of the half ball of radius 1 about +z, [samples][4]: distance 0.1 + 0.9 (i / K)^2; directions uniform over the
// half sphere. published: those of a cube's points, LRA 6.2.3, by hashes in place of rand().
Buffer<float> half_ball(const AoParams& params);
// [16][2]: by which the pixels of 4 x 4 turn them.
Buffer<float> rotations(const AoParams& params);

}  // namespace plumb::screen
