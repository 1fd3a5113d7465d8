// Curves on a white picture, with axes: for pictures that are files of their own, without a page around them.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/image.h"

namespace plumb::probes {

struct PlotTick {
    double at = 0;      // 0 to 1 along the axis, from the left or from the bottom
    std::string label;  // digits, and the letters e, i and s, '-', '/'; others are left blank
};

struct PlotAxes {
    std::vector<PlotTick> across = {}, upwards = {};  // each with a pale line through the picture
    std::string across_name = {}, upwards_name = {};
};

// An empty plot of that size, at least 160 x 120 pixels.
class Plot {
  public:
    Plot(glm::ivec2 size, const PlotAxes& axes);
    // Joins the points, each 0 to 1 from the left and from the bottom; what lies beyond is left out.
    void curve(const std::vector<glm::dvec2>& points, const glm::vec4& colour);
    const Image4& picture() const { return picture_; }

  private:
    glm::ivec2 texel(glm::dvec2 at) const;
    void write(glm::ivec2 at, const std::string& text);
    Image4 picture_;
    glm::ivec2 low_, high_;  // corners of the plane that curves lie in: left and top, right and bottom
};

}  // namespace plumb::probes
