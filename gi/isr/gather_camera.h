// isr.gather_camera: isr.gather from an additional camera's image, samples around the receivers' projections.
#pragma once

#include <fmt/format.h>

#include "core/binding.h"
#include "gi/isr/gather.h"
#include "gi/isr/gather_camera_kernel.h"
#include "gi/isr/isr_params.h"
#include "raster/covered.h"

namespace plumb::isr {

struct CameraGatherInputs {
    using Kernel = GatherCameraKernel;
    const Image4* surface = nullptr;           // of the receivers
    CoarseCamera camera;
    const Image4* source_surface = nullptr;    // isr.unseen's
    const Image4* source_radiosity = nullptr;
    CoarseCamera source_camera;
    const Image4* before = nullptr;            // as GatherInputs has it
    const Pattern* pattern = nullptr;
    std::uint32_t seed = 1;
    const raster::Covered* tiles = nullptr;
};

inline StageDescription<GatherCameraInputsView> describe(GatherCameraKernel) {
    using View = GatherCameraInputsView;
    const auto camera = [](const View& v) { return glm::ivec2(v.u.camera.width, v.u.camera.height); };
    const std::string why = "as camera.width and camera.height say";
    return {
        .name = "isr.gather_camera",
        .source = "ISR chapter 6 (additional cameras), (25) and (6)",
        .domain = "coarse pixel",
        .inputs = {{.name = "surface", .at = &View::surface, .unit = "m", .meaning = "receivers: xyz unit normal, w depth"},
                   {.name = "source_surface", .at = &View::source_surface, .unit = "m",
                    .meaning = "what only the camera sees: xyz unit normal, w depth", .size = camera, .why = why},
                   {.name = "source_radiosity", .at = &View::source_radiosity, .unit = "W/m2", .meaning = "of the camera",
                    .size = camera, .why = why},
                   {.name = "before", .at = &View::before, .unit = "W/m2",
                    .meaning = "what other sources sent; w: sum of form factors", .optional = true},
                   {.name = "offsets", .at = &View::offsets, .unit = "coarse pixels", .meaning = "[samples][rotations]",
                    .count = [](const View& v) { return std::size_t(sample_count(v.u.u.rings)) * std::size_t(v.u.u.rotations); },
                    .why = "samples x rotations"},
                   {.name = "weights", .at = &View::weights, .meaning = "[samples]: how many patches of area a sample stands for",
                    .count = [](const View& v) { return std::size_t(sample_count(v.u.u.rings)); }, .why = "one for each sample", .optional = true}},
        .outputs = {{.name = "gathered", .at = &View::gathered, .unit = "W/m2",
                     .meaning = "irradiance; w: sum of form factors"}},
        .params = params_of({"pattern", "rings", "reach", "growth", "spacing", "rotations", "turn", "far_rings", "full_depth", "cameras", "camera_angle",
                             "position", "least_cosine"}),
        .uniforms = {{"u.rings", 0, 127}, {"camera.width", 1, 32767}, {"camera.height", 1, 32767}},
        .refuses = [](const View& v, glm::ivec2) -> std::string {
            const int rotations = v.u.u.rotations;
            if (rotations >= 1 && (rotations & (rotations - 1)) == 0) return "";
            return fmt::format("u.rotations = {}: expected a power of two", rotations);
        },
        .cost = {1, "samples"},
    };
}

StageData data_of(const IsrParams& params, const CameraGatherInputs& in);

}  // namespace plumb::isr
