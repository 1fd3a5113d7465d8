// A lightmap whose truth is traced: its receivers, and what a lookup finds there. Host only, as gi/reference is.
#pragma once

#include <array>

#include "gi/probes/bake.h"
#include "gi/probes/receiver_irradiance.h"

namespace plumb::probes {

struct Lightmap {
    Atlas atlas;
    raster::Surfaces surfaces;
    Receivers receivers;
    int moved = 0;  // receivers that lay inside of something
};

// Receivers of an atlas as the nodes probes.atlas and probes.receivers of a bake with these parameters make them. Throws what
// place_receivers() throws.
Lightmap place_lightmap(const Scene& scene, Atlas atlas, const BakeParams& params, const RunOptions& options);

// The texels that a bilinear lookup reads, as a GPU does: centres at + 0.5, clamped to the edge.
struct Bilinear {
    std::array<glm::ivec2, 4> texel;
    std::array<double, 4> weight;
};
Bilinear bilinear(const glm::dvec2& at_texels, const glm::ivec2& size);

// What stands, or should stand, in a texel.
struct TexelValue {
    bool known = false;
    glm::dvec3 value{0}, error{0};  // W/m2; standard error
};

// The truth of a lightmap chart by chart: a lookup on a chart means that chart, also where another one lies in its texels.
class ChartTexels {
  public:
    // All must outlive it.
    ChartTexels(const Atlas& atlas, const Receivers& receivers, const ReceiverIrradiance& truth);

    int receiver_at(const glm::ivec2& texel) const;  // -1: none
    std::int32_t chart_of(int receiver) const { return atlas_.chart[std::size_t(receivers_.triangle[std::size_t(receiver)])]; }
    // The receiver's, if it is the chart's; beside the chart the mean of its receivers among the 8 neighbours, as
    // extend_borders() has it; else unknown.
    TexelValue expected(std::int32_t chart, const glm::ivec2& texel) const;
    // Of a lookup; unknown where a texel of it is. Its error is that of a weighted sum of independent receivers.
    TexelValue lookup(std::int32_t chart, const Bilinear& from) const;

    const Atlas& atlas() const { return atlas_; }
    const Receivers& receivers() const { return receivers_; }
    const ReceiverIrradiance& truth() const { return truth_; }

  private:
    const Atlas& atlas_;
    const Receivers& receivers_;
    const ReceiverIrradiance& truth_;
    // A texel as a mean of receivers: how many, and which.
    int receivers_of(std::int32_t chart, const glm::ivec2& texel, std::array<int, 8>& which) const;

    Image<std::int32_t> receiver_;
};

}  // namespace plumb::probes
