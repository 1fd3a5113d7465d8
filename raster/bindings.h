// The stages gbuffer, gbuffer.layer and rsm bound by name (core/binding.h).
#pragma once

#include "core/binding.h"
#include "core/scene.h"
#include "core/view.h"
#include "raster/light_kernel.h"
#include "raster/surfaces.h"

namespace plumb::raster {

// The twins' blocks: the build holds them against the twins' SPIR-V.
struct GBufferUniforms {
    float viewer[4];   // SurfaceArgs
    float eye[3], padding;
    float forward[3];
    float pixel_area;  // 0 where no texture has levels
};
struct GBufferLayerUniforms {
    float viewer[4];
    float eye[3];
    float farther;     // 1; reversed z: -1
    float forward[3];
    float pixel_area;
};
struct RsmUniforms {
    float viewer[4];
    float eye[3], padding;
    float forward[3];
    float pixel_area;
    LightArgs light;
    float texel_scale, half_width, tail[2];
};

const StageBinding& gbuffer_binding();
const StageBinding& gbuffer_layer_binding();
const StageBinding& rsm_binding();
// What raster/surface.glsl reads: inputs of every stage that looks at surfaces, with a twin or without.
std::vector<Port> surface_ports();

// One draw, with copies of all it reads; label and id are the caller's. What is empty has one element of zeros, for no
// device binds an empty buffer: a triangle of zeros draws nothing.
StageData gbuffer_data(const Geometry& geometry, const Surfaces& surfaces, const View& view, glm::ivec2 size);
// `behind`: peeled_depth() of the layer before.
StageData gbuffer_layer_data(const Geometry& geometry, const Surfaces& surfaces, const View& view, glm::ivec2 size,
                             const Image1& behind);
StageData rsm_data(const Geometry& geometry, const Surfaces& surfaces, const Light& light, const View& light_view);

}  // namespace plumb::raster
