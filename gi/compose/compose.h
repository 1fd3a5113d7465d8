// The stages compose and tonemap: from irradiance to radiance to the values of a display. See gi/compose/README.md.
#pragma once

#include <vector>

#include "core/stage_description.h"
#include "gi/compose/compose_kernel.h"
#include "gi/compose/compose_params.h"
#include "gi/compose/tonemap_kernel.h"
#include "gi/lend.h"

namespace plumb::compose {

using plumb::explain;
using plumb::run;

struct ComposeInputs {
    using Kernel = ComposeKernel;
    const Image4* normal = nullptr;    // w: 1 on a surface, 0 where nothing is
    const Image4* albedo = nullptr;    // rho
    const Image4* emission = nullptr;  // W/m2
    const Image4* direct = nullptr;    // W/m2; w: shadow density
    const Image4* indirect = nullptr;  // W/m2
    glm::vec3 environment{0};          // W/(m2 sr)
};

inline StageDescription<ComposeInputsView> describe(ComposeKernel) {
    using View = ComposeInputsView;
    ComposeParams defaults;
    return {
        .name = "compose",
        .source = "VRSM 4.5 (direct light plus indirect light), 4.3 (shadow colour)",
        .domain = "pixel",
        .inputs = {{.name = "normal", .at = &View::normal, .meaning = "w: 1 on a surface, 0 where nothing is", .fixed = 8},
                   {.name = "albedo", .at = &View::albedo, .meaning = "diffuse reflectance rho"},
                   {.name = "emission", .at = &View::emission, .unit = "W/m2", .meaning = "radiant exitance M"},
                   {.name = "direct", .at = &View::direct, .unit = "W/m2",
                    .meaning = "direct irradiance; w: shadow density"},
                   {.name = "indirect", .at = &View::indirect, .unit = "W/m2", .meaning = "indirect irradiance"}},
        .outputs = {{.name = "radiance", .at = &View::radiance, .unit = "W/(m2 sr)",
                     .meaning = "outgoing radiance towards the viewer"}},
        .params = plumb::describe(fields(defaults)),
        .cost = {5, "pixels"},
    };
}
StageData data_of(const ComposeParams& params, const ComposeInputs& in);

struct TonemapInputs {
    using Kernel = TonemapKernel;
    const Image4* radiance = nullptr;  // W/(m2 sr)
};

inline StageDescription<TonemapInputsView> describe(TonemapKernel) {
    using View = TonemapInputsView;
    TonemapParams defaults;
    return {
        .name = "tonemap",
        .source = "IPR 3.3 (exposure, Reinhard, filmic); IEC 61966-2-1",
        .domain = "pixel",
        .inputs = {{.name = "radiance", .at = &View::radiance, .unit = "W/(m2 sr)", .meaning = "outgoing radiance"}},
        .outputs = {{.name = "display", .at = &View::display, .meaning = "encoded (sRGB, or a power), 0..1; w 1"}},
        .params = plumb::describe(fields(defaults)),
        .uniforms = {{"op", 0, int(Operator::filmic)}},
        .cost = {25, "pixels"},
    };
}
StageData data_of(const TonemapParams& params, const TonemapInputs& in);

// What a PNG holds: rint(255 x), nearest even; red, green, blue of each pixel.
std::vector<unsigned char> to_bytes(const Image4& display);

}  // namespace plumb::compose
