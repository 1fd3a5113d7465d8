// The parts of check_lightmap(). Private to gi/probes/lightmap_*.cpp.
#pragma once

#include "core/compare_pictures.h"
#include "gi/probes/lightmap_check.h"

namespace plumb::probes {

// What all parts read.
struct CheckInputs {
    const Image4& map;
    const ChartTexels& truth;  // whose errors are those of truth and map together
    const ChartTexels& alone;  // the truth with its own errors
    const CheckParams& params;
    double median = 0;  // of the truth's luminance
    double floor = 0;   // W/m2, above 0: light by which nothing less is divided

    const Atlas& atlas() const { return truth.atlas(); }
    const Receivers& receivers() const { return truth.receivers(); }
    bool is_inside(int receiver) const { return receivers().shift[std::size_t(receiver)].w != 0; }
    double user_at(const glm::ivec2& t) const { return compare::luminance(glm::dvec3(map(t.x, t.y))); }
    glm::dvec3 user_lookup(const Bilinear& from) const {
        glm::dvec3 sum(0);
        for (std::size_t k = 0; k < 4; ++k) sum += from.weight[k] * glm::dvec3(map(from.texel[k].x, from.texel[k].y));
        return sum;
    }
};

inline double luminance_of(const glm::vec4& rgb) { return compare::luminance(glm::dvec3(rgb)); }
Place place_of(const CheckInputs& in, int receiver);

void find_seams(const CheckInputs& in, LightmapCheck& out);
void find_leaks(const CheckInputs& in, LightmapCheck& out);
void find_bleeding(const CheckInputs& in, LightmapCheck& out);

}  // namespace plumb::probes
