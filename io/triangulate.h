// Polygons to triangles. Private to io/.
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <vector>

namespace plumb::io {

// More corners than this must form a convex polygon: clipping ears takes up to the third power of them.
inline constexpr std::size_t max_concave_corners = 1024;

// Splits the polygon into corners.size() - 2 triangles of corner numbers, in the polygon's own direction. Convex ones
// become a fan around corner 0; others lose one ear after another (Meisters 1975, "Polygons have ears"), seen along
// their normal. Where no ear is left, as in a polygon that crosses itself, the rest is a fan. False: too many corners
// for a concave polygon.
bool triangulate(const std::vector<glm::vec3>& corners, std::vector<std::array<std::uint32_t, 3>>& triangles);

}  // namespace plumb::io
