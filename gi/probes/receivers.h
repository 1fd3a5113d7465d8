// Receivers: the texels of the lightmap that a surface covers (IPR 3.2.1.2), which of their neighbours they extend into
// (IPR 3.2.1.1, figure 3.12), and from where they look when they lie inside of something (IPR 5.1.4).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/isa.h"
#include "core/ray_query.h"
#include "gi/probes/atlas.h"
#include "raster/surfaces.h"

namespace plumb::probes {

// Bits of Receivers::border: the neighbour is no receiver, and this one writes there, too. IPR 3.2.5.8 has four bits; it does
// not say which is which.
enum Border : std::uint32_t { border_left = 1, border_right = 2, border_up = 4, border_down = 8 };
inline constexpr std::array<glm::ivec2, 4> border_steps = {{{-1, 0}, {1, 0}, {0, -1}, {0, 1}}};  // in the order of the bits

// What is known of each receiver, in the order of the lightmap's rows.
struct Receivers {
    Buffer<glm::vec4> position;          // xyz world, m: from where it looks, moved out of what it lies in; w 0
    Buffer<glm::vec4> normal;            // xyz unit, w 0
    Buffer<glm::vec4> shift;             // xyz m: how far it was moved; w 1 where it was, else 0
    std::vector<glm::ivec2> texel;       // of the lightmap
    std::vector<std::int32_t> material;  // index into Scene::materials
    std::vector<std::int32_t> triangle;  // of Atlas::geometry
    std::vector<std::uint32_t> border;
    glm::ivec2 size{0};                  // of the lightmap

    int count() const { return int(position.size()); }
};

// Covered texels of the atlas, not moved. Throws InputError where nothing is covered.
Receivers place_receivers(const Atlas& atlas, const raster::Surfaces& surfaces, const RunOptions& options);

struct ShiftParams {
    int rays = 64;       // over the hemisphere of the normal; 0: nothing is moved
    double share = 0.5;  // of them that must start inside of something; none may meet nothing
    int crossings = 64;  // surfaces that a ray is followed through to tell; 1: as published, the first alone
    bool in_the_air = false;  // rays go in all directions, and those that meet nothing are left out (IPR 4.1.1)
};
// Moves receivers that lie inside of solids along the shortest test ray that leads out, and `offset` m beyond. Returns how many.
//
// differs: IPR 5.1.4 calls a ray inside whose first hit is a back, and asks 60 %. Where solids overlap, as the boxes of a stair,
// the first hit is the front of another as often, and behind a back may lie the next. Half of the rays may look at a floor that
// lies in the plane of the solid's underside: of the two they meet one.
int shift_receivers(Receivers& receivers, const raster::SurfaceArgs& surfaces, const RayQuery& query, float offset,
                    const ShiftParams& params, const RunOptions& options);

// How far rays keep off surfaces whose coordinates are at most `extent` m: what rounding may move a point by.
float offset_of(float extent);
float extent_of(const Geometry& geometry);

// ---- Border texels ---------------------------------------------------------------------------------------------------

// The lightmap of a value of each receiver; other texels are 0.
Image4 scatter(const Receivers& receivers, const Buffer<glm::vec4>& values);

// Writes into each texel beside a chart the mean of the receivers among its 8 neighbours, added in the order of rows, and into
// those beside them the mean of these: what a bilinear lookup at the chart's edge reads. The second ring is for sharp corners,
// which reach beyond their last receiver; with a gap of 3 texels it reaches nothing that a lookup in another chart reads.
//
// differs: the four bits extend along rows and columns alone, so that a texel at a corner stays black, and two receivers may
// write one texel: `published` does so, each receiver in the order of the lightmap's rows.
inline constexpr int border_rings = 2;
Image4 extend_borders(const Receivers& receivers, const Image4& lightmap, bool published = false);

}  // namespace plumb::probes
