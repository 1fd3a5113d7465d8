// Clipping in homogeneous space (Sutherland and Hodgman 1974, "Reentrant Polygon Clipping").
#pragma once

#include <glm/glm.hpp>

namespace plumb::raster {

// A vertex in clip space and its barycentric coordinates l1, l2 with respect to the whole triangle.
struct ClipVertex {
    glm::dvec4 position;
    glm::dvec2 barycentrics;
};

// Three corners and one more for each of the six planes.
struct ClipPolygon {
    static constexpr int capacity = 9;
    ClipVertex vertices[capacity];
    int count = 0;
};

// A frame's view volume: 0 <= z <= w, and |x| <= guard.x w, |y| <= guard.y w.
struct ClipVolume {
    glm::dvec2 guard{1};
};

// The guard band ends 65,536 pixels away from the frame's top left corner on the far side, so that window coordinates
// in 1/256 pixel stay within 2^24 and edge functions (raster/screen_triangle.h) are exact.
ClipVolume clip_volume(glm::ivec2 size);

// True where the triangle lies wholly beyond one plane of the frame's own volume, |x| <= w, |y| <= w, 0 <= z <= w.
bool outside_frame(const glm::vec4 corners[3]);

// True where the point is within the volume.
bool inside(const ClipVolume& volume, const glm::vec4& corner);

// The part of the triangle within the volume; count is 0 where there is none. Vertices that two triangles share, and
// those that arise on a shared edge, come out with the same bits in both: the clipped mesh has no cracks.
ClipPolygon clip(const ClipVolume& volume, const glm::vec4 corners[3]);

}  // namespace plumb::raster
