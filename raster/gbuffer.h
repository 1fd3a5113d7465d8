// The stage gbuffer: what the camera sees, as deferred shading reads it. See raster/README.md.
#pragma once

#include <vector>

#include "core/image.h"
#include "core/isa.h"
#include "core/scene.h"
#include "core/tap.h"
#include "core/view.h"
#include "raster/covered.h"
#include "raster/layout.h"
#include "raster/surfaces.h"

namespace plumb::raster {

// Which buffers a later stage reads. The others come back empty, and what they alone need is not computed: without
// albedo and emission no texture is read.
struct GBufferWants {
    bool position = true, normal = true, albedo = true, emission = true, id = true;
};

struct Workspace;  // raster/workspace.h

struct GBuffer {
    Image4 position;       // xyz world, m; w: linear eye depth, m; all 0 where there is nothing
    Image4 normal;         // xyz unit, on the side of the triangle that the viewer sees; w: 1 covered, 0 nothing
    Image4 albedo;         // xyz: diffuse reflectance rho, linear; w: 0, or the layout's radiation mask
    Image4 emission;       // xyz: radiant exitance, W/m2
    Image1 depth;          // z of the depth buffer; where nothing: 1 (reversed z: 0)
    Image<glm::ivec2> id;  // object, triangle; -1, -1 where there is nothing
    Image1 exact_depth;    // `depth` as it was drawn, where the layout rounds it; else empty
    Covered covered;       // where the position, the normal or a colour is not 0 everywhere
};

// What a layer behind this one has to lie behind: z as the depth test knew it. A rounded one would let half of what was
// seen be seen again.
inline const Image1& peeled_depth(const GBuffer& g) { return g.exact_depth.empty() ? g.depth : g.exact_depth; }

// Buffers are rounded as the layout says. Those of `out` that have the right size are written in place. Throws
// InputError for what the layout cannot hold (check_gbuffer() of raster/layout.h).
//
// `behind`: peeled_depth() of the layer before, drawn of the same geometry and view at the same size: this is then the
// next layer (depth peeling; ISR ch. 6). Not a buffer of `out`.
void draw_gbuffer(const Geometry& geometry, const Surfaces& surfaces, const View& view, glm::ivec2 size,
                  const Layout& layout, const RunOptions& options, GBuffer& out, const GBufferWants& wants = {},
                  Workspace* workspace = nullptr, const Image1* behind = nullptr);

// Every named value of one pixel, in the order in which the kernel computes them, before rounding to the layout; then
// what the layout makes of position, normal, albedo and emission: "stored_position" and so on.
std::vector<TapValue> explain_gbuffer(const Geometry& geometry, const Surfaces& surfaces, const View& view,
                                      glm::ivec2 size, glm::ivec2 pixel, const Layout& layout = Layout::fp32,
                                      const Image1* behind = nullptr);

}  // namespace plumb::raster
