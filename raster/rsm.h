// The stage rsm: a reflective shadow map, what a light sees and the flux that each texel reflects (VRSM 4.2, LRA
// 4.2.2). See raster/README.md.
#pragma once

#include <limits>
#include <vector>

#include "core/image.h"
#include "core/isa.h"
#include "core/scene.h"
#include "core/tap.h"
#include "core/view.h"
#include "raster/layout.h"
#include "raster/surfaces.h"

namespace plumb::raster {

struct Workspace;  // raster/workspace.h

// What a later stage reads of a map. A shadow test reads position and depth, and the normal where it asks for planes: without
// `light` flux and records come back empty, without both normals, too, and what they alone need is not computed; no texture is
// read, but for alpha and of normals.
struct RsmWants {
    bool light = true;
    bool normal = true;  // that alone; `light` brings it, too

    bool normals() const { return light || normal; }
};

struct Rsm {
    int size = 0;  // texels a side
    View view;
    LightType type = LightType::spot;
    bool half = false;          // which of the records are filled
    Image4 position;            // xyz world, m; w: linear light-space depth, m; all 0 where there is nothing
    Image4 normal;              // xyz unit, on the side that the light sees; w: 1 covered, 0 nothing
    Image4 flux;                // xyz W, reflected; w 0
    Buffer<float> records;      // !half: [size][size] records of 64 bytes (core/number.h): position, normal, flux
    Buffer<Half> half_records;  // half: records of 32 bytes
    float largest_flux = std::numeric_limits<float>::infinity();  // W, of any texel and channel; infinite: not known
    double texel_scale = 0;     // side of a texel: spot: at depth 1 m, m/m; directional: m
};

// A map that nothing was drawn into yet, as draw_rsm() leaves one of an empty scene, without its records.
Rsm unseen_rsm(const Light& light, const View& light_view);

// light.rsm_size texels a side, through a view of light_views(), raster/light_view.h: a point light takes six calls.
// Images are rounded as the layout says. Memory of `out` that has the right size is written in place. Throws InputError
// for what the layout cannot hold (check_rsm() of raster/layout.h).
void draw_rsm(const Geometry& geometry, const Surfaces& surfaces, const Light& light, const View& light_view,
              const Layout& layout, const RunOptions& options, Rsm& out, Workspace* workspace = nullptr,
              const RsmWants& wants = {});

// Every named value of one texel, in the order in which the kernel computes them, before rounding to the layout; then
// what the layout makes of position, normal and flux: "stored_position" and so on.
std::vector<TapValue> explain_rsm(const Geometry& geometry, const Surfaces& surfaces, const Light& light,
                                  const View& light_view, glm::ivec2 texel, const Layout& layout = Layout::fp32);

}  // namespace plumb::raster
