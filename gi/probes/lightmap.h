// A lightmap whose truth is traced: its receivers, and what a lookup finds there. Host only, as gi/reference is.
#pragma once

#include <array>
#include <utility>
#include <vector>

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
    // The receiver's, if it is the chart's; beside the chart the mean that extend_borders() has, of the chart's
    // receivers alone; else unknown.
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
    using Weights = std::vector<std::pair<int, double>>;  // receivers, each once
    bool is_of(std::int32_t chart, const glm::ivec2& texel) const;
    // Neighbours of a texel beside the chart: those of the chart, or, ring 2, those that have such neighbours.
    std::vector<glm::ivec2> beside(std::int32_t chart, const glm::ivec2& texel, int ring) const;
    // Adds a texel as a mean of receivers; false: it is farther from the chart than its borders reach.
    bool add_receivers(std::int32_t chart, const glm::ivec2& texel, double weight, Weights& weights) const;

    Image<std::int32_t> receiver_;
};

}  // namespace plumb::probes
