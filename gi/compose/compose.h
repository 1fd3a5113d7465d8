// The stages compose and tonemap: from irradiance to radiance to the values of a display. See gi/compose/README.md.
#pragma once

#include <vector>

#include "core/image.h"
#include "core/isa.h"
#include "core/stage.h"
#include "core/tap.h"
#include "gi/compose/tonemap_kernel.h"

namespace plumb::compose {

struct ComposeParams {
    glm::vec3 shadow_color{0};  // W/(m2 sr)
};
std::vector<Field> fields(ComposeParams& params);
// Whether the shadow density is read: not by a black shadow colour.
inline bool reads_density(const ComposeParams& params) { return params.shadow_color != glm::vec3(0); }

struct ComposeInputs {
    const Image4* normal = nullptr;    // w: 1 on a surface, 0 where nothing is
    const Image4* albedo = nullptr;    // rho
    const Image4* emission = nullptr;  // W/m2
    const Image4* direct = nullptr;    // W/m2; w: shadow density
    const Image4* indirect = nullptr;  // W/m2
    glm::vec3 environment{0};          // W/(m2 sr)
};
void validate(const ComposeInputs& inputs);
void run(const ComposeParams& params, const ComposeInputs& inputs, const RunOptions& options, Image4& radiance);
std::vector<TapValue> explain(const ComposeParams& params, const ComposeInputs& inputs, glm::ivec2 pixel);
StageInfo compose_info();

struct TonemapParams {
    Operator op = Operator::exposure;
    float exposure = 1;
};
std::vector<Field> fields(TonemapParams& params);

// display: sRGB-encoded 0..1 in xyz, w = 1.
void run(const TonemapParams& params, const Image4& radiance, const RunOptions& options, Image4& display);
std::vector<TapValue> explain(const TonemapParams& params, const Image4& radiance, glm::ivec2 pixel);
StageInfo tonemap_info();

// What a PNG holds: rint(255 x), nearest even; red, green, blue of each pixel.
std::vector<unsigned char> to_bytes(const Image4& display);

}  // namespace plumb::compose
