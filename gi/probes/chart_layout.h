// What charts touch inside their rectangles of texels.
#pragma once

#include <vector>

#include "gi/probes/chart_shape.h"

namespace plumb::probes {

// Whether islands that stay as they were laid out leave `gap` texels between each other, and fill a quarter of their
// rectangle with theirs.
bool apart(const SurfaceMesh& mesh, const std::vector<ChartShape>& islands, const TexelRectangle& rectangle,
           double scale, int gap);

struct TexelHole {
    glm::ivec2 origin{0}, size{0};  // texels, from the rectangle's corner
};

// Rectangles of texels that lie farther than `gap` from any that a chart touches: where smaller charts find room
// (figures 3.9 and 3.10; differs: IPR knows the margin beside and below a chart only, not the inside of an arch). The
// largest first, at most eight, none below a 64th of the chart's rectangle; none at all in charts that fill four
// fifths.
std::vector<TexelHole> holes(const SurfaceMesh& mesh, const ChartShape* shapes, std::size_t count,
                             const TexelRectangle& rectangle, double scale, int gap);

}  // namespace plumb::probes
