// What a device makes of a triangle before any pixel, where planes go through its snapped corners and clipping cuts its
// outline alone: SwiftShader (README.md, "Devices"). Call these functions within FlushedDenormals, device_triangle.h.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "core/device_profile.h"
#include "core/number.h"
#include "raster/device_triangle.h"

namespace plumb::raster {

// A triangle's outline, clipped, and the planes of the whole triangle.
struct DevicePolygon {
    static constexpr int capacity = 9;
    std::int32_t x[capacity], y[capacity];  // 1/256 pixel, multiples of the profile's grid
    int count;
    bool turned;                            // its corners run against the way of the outline
    float anchor_x, anchor_y;               // pixels: where the planes have their value `at_origin`
    Plane depth;                            // of the depth buffer
    Plane inverse_w, l1, l2;                // l1 and l2 are divided by w
    std::int32_t triangle;                  // index into Geometry::triangles
};

PLUMB_INLINE float at(const DevicePolygon& p, const Plane& plane, int x, int y) {
    return (plane.at_origin + (float(y) - p.anchor_y) * plane.along_y) + (float(x) - p.anchor_x) * plane.along_x;
}
PLUMB_INLINE float depth_at(const DevicePolygon& p, int x, int y, bool) {
    const float depth = at(p, p.depth, x, y);
    return depth > 0 ? min(depth, 1.0f) : 0.0f;
}
PLUMB_INLINE glm::vec2 barycentrics_at(const DevicePolygon& p, int x, int y, bool) {
    const float w = 1.0f / at(p, p.inverse_w, x, y);
    return {at(p, p.l1, x, y) * w, at(p, p.l2, x, y) * w};
}

// The columns [first, last] of a row that the outline encloses; empty: first > last.
void covered_columns(const DevicePolygon& p, int row, int width, int& first, int& last);

void append_device_shape(std::vector<DevicePolygon>& out, const glm::vec4 corners[3], std::int32_t triangle,
                         glm::ivec2 size, const DeviceProfile& profile);

}  // namespace plumb::raster
