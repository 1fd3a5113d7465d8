// isr.blur: a Gaussian along rows or columns of the coarse result (ISR 4.2, Listing 3).
#pragma once

#include "core/binding.h"
#include "gi/isr/blur_kernel.h"
#include "gi/isr/isr_params.h"
#include "raster/covered.h"

namespace plumb::isr {

enum class Direction : int { horizontal, vertical };

struct BlurInputs {
    using Kernel = BlurKernel;
    const Image4* lit = nullptr;         // xyz irradiance, W/m2, w accessibility
    const Image4* surface = nullptr;
    CoarseCamera camera{};          // that sees `surface`; read by edge_aware alone
    Direction direction = Direction::horizontal;
    const raster::Covered* tiles = nullptr;
};

inline StageDescription<BlurInputsView> describe(BlurKernel) {
    using View = BlurInputsView;
    return {
        .name = "isr.blur",
        .source = "ISR 4.2, Listing 3 (Gaussian blur of the coarse result, horizontal and vertical)",
        .domain = "coarse pixel",
        .inputs = {{.name = "lit", .at = &View::lit, .unit = "W/m2", .meaning = "irradiance; w: accessibility"},
                   {.name = "surface", .at = &View::surface, .meaning = "unit normal; w: linear eye depth, m"},
                   {.name = "spatial", .at = &View::spatial,
                    .meaning = "[2 radius + 1]: Gaussian of the distance; its sum is 1",
                    .count = [](const View& v) { return std::size_t(2 * v.u.radius + 1); },
                    .why = "a weight for each pixel of the kernel"}},
        .outputs = {{.name = "blurred", .at = &View::blurred, .unit = "W/m2", .meaning = "irradiance; w: accessibility",
                     .unwritten = {0, 0, 0, 1}}},
        .params = params_of({"variant", "blur", "blur_radius", "blur_sigma"}),
        .uniforms = {{"kind", 0, int(BlurKind::published)}, {"vertical", 0, 1}, {"radius", 0, BlurPlanes::padding}},
        .cost = {1, "samples"},
    };
}

StageData data_of(const IsrParams& params, const BlurInputs& in);

// g of blur_kernel.h, [2 radius + 1]; blur = none: one weight, 1.
Buffer<float> blur_weights(const IsrParams& params);

}  // namespace plumb::isr
