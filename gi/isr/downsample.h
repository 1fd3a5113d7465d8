// isr.downsample: buffers of a quarter of the pixels (ISR 4.2, Listing 3).
#pragma once

#include <fmt/format.h>

#include "core/binding.h"
#include "gi/isr/downsample_kernel.h"
#include "gi/isr/isr_params.h"
#include "raster/covered.h"

namespace plumb::isr {

// surface: xyz unit normal, w linear eye depth, m (position = inverse_matrix: clip depth); all 0 where none is.
// radiosity: xyz W/m2, w the radiation mask. reflectance: xyz rho.
enum class Coarse : int { surface, radiosity, reflectance };

struct DownsampleInputs {
    using Kernel = DownsampleKernel;
    Coarse what = Coarse::surface;
    const Image4* position = nullptr;  // w: linear eye depth, m
    const Image4* normal = nullptr;    // xyz unit, w 1; all 0 where nothing is
    const Image4* albedo = nullptr;    // rho; w: radiation mask where the layout has one
    const Image4* emission = nullptr;  // radiant exitance, W/m2
    const Image4* direct = nullptr;    // irradiance, W/m2
    double near = 0, far = 0;          // m; read by position = inverse_matrix
    const raster::Covered* tiles = nullptr;  // of coarse pixels: the others get 0; null: all are computed
};

inline StageDescription<DownsampleInputsView> describe(DownsampleKernel) {
    using View = DownsampleInputsView;
    const auto full = [](const View& v) { return glm::ivec2(v.u.full_width, v.u.full_height); };
    const auto lit = [](const View& v) { return v.u.what == int(Coarse::radiosity) && v.u.published == 0; };
    const std::string why = "as full_width and full_height say";
    return {
        .name = "isr.downsample",
        .source = "ISR 4.2, Listing 3: buffers of a quarter of the pixels",
        .domain = "coarse pixel",
        .inputs = {{.name = "position", .at = &View::position, .unit = "m", .meaning = "w: linear eye depth", .size = full,
                    .why = why, .read = [](const View& v) { return v.u.what == int(Coarse::surface); }},
                   {.name = "normal", .at = &View::normal, .meaning = "unit normal, w 1", .fixed = 0b1000, .size = full,
                    .why = why},
                   {.name = "albedo", .at = &View::albedo, .meaning = "reflectance; w: radiation mask", .size = full,
                    .why = why, .read = [](const View& v) { return v.u.what != int(Coarse::surface); }},
                   {.name = "emission", .at = &View::emission, .unit = "W/m2", .meaning = "radiant exitance", .size = full,
                    .why = why, .read = lit},
                   {.name = "direct", .at = &View::direct, .unit = "W/m2", .meaning = "direct irradiance", .size = full,
                    .why = why, .read = lit}},
        .outputs = {{.name = "coarse", .at = &View::coarse,
                     .meaning = "surface, radiosity or reflectance of a quarter of the pixels"}},
        .params = params_of({"variant", "resolution", "position"}),
        .uniforms = {{"what", 0, int(Coarse::reflectance)}, {"full_width", 1, 32767}, {"full_height", 1, 32767}},
        .refuses = [](const View& v, glm::ivec2 size) -> std::string {
            const glm::ivec2 full(v.u.full_width, v.u.full_height);
            const bool native = v.u.native != 0;
            if (full.x >= 1 && full.y >= 1 && coarse_size(full, native ? 1 : 2) == size) return "";
            return fmt::format("{} x {} of {} x {}: expected {}", size.x, size.y, full.x, full.y,
                               native ? "the same" : "half of it, rounded up");
        },
        .cost = {4, "pixels"},
    };
}

StageData data_of(const IsrParams& params, const DownsampleInputs& in);

}  // namespace plumb::isr
