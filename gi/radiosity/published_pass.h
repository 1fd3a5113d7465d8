// A pass as HEM 5.6 has it, steps 3 to 5: from each element the scene is drawn again, and its texels' colours are added up by
// their weights. The slow version of form_factors() and gather(), and what buffers of 8 bits can be tried in (5.7).
#pragma once

#include <array>
#include <functional>

#include "gi/radiosity/reduce.h"
#include "gi/radiosity/rows.h"

namespace plumb::radiosity {

struct PublishedPass {
    RowParams row;
    // What a texel holds of the radiosities at its triangle's corners and their barycentrics, W/m2. Empty: linear between them.
    std::function<glm::vec3(const std::array<glm::vec3, 3>& corners, const glm::vec3& barycentrics)> texel;
    Reduction reduction;  // by radiosity.reduce; else texels are added in their order, in double
};

struct PassTimes {
    double draw_seconds = 0, sum_seconds = 0;
};

// H of elements [first, first + count) from B of all, W/m2.
PassTimes published_irradiance(const Elements& elements, const PublishedPass& pass, const Buffer<glm::vec4>& radiosity, int first,
                               int count, const RunOptions& options, Buffer<glm::vec4>& irradiance);

}  // namespace plumb::radiosity
