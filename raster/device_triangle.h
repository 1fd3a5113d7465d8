// What a device makes of a triangle before any pixel, where planes go through unsnapped window positions: Mesa's
// llvmpipe, in float and in its order (README.md, "Devices": formulas and evidence; device_polygon.h is another). Call these functions within FlushedDenormals: the device takes denormals for 0 in every stage of its drawing.
#pragma once

#include <xmmintrin.h>

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "core/device_profile.h"
#include "core/number.h"
#include "raster/screen_triangle.h"

namespace plumb::raster {

// Denormal operands and results count as 0 of their sign while it lives.
class FlushedDenormals {
  public:
    FlushedDenormals() : saved_(_mm_getcsr()) { _mm_setcsr(saved_ | 0x8040); }
    ~FlushedDenormals() { _mm_setcsr(saved_); }
    FlushedDenormals(const FlushedDenormals&) = delete;
    FlushedDenormals& operator=(const FlushedDenormals&) = delete;

  private:
    unsigned saved_;
};

// at_origin + along_x x + along_y y, at pixel (x, y): its centre is accounted for in at_origin.
struct Plane {
    float at_origin, along_x, along_y;
};
PLUMB_INLINE float at(const Plane& p, int x, int y, bool fma) {
    if (fma) return fused(p.along_y, float(y), fused(p.along_x, float(x), p.at_origin));
    return (p.along_x * float(x) + p.at_origin) + p.along_y * float(y);
}

// A triangle, or a piece of a clipped one.
struct DeviceTriangle {
    static constexpr int count = 3;
    std::int32_t x[3], y[3];   // 1/256 pixel, multiples of the profile's grid
    Plane depth;               // of the depth buffer
    Plane inverse_w, l1, l2;   // l1 and l2 are divided by w
    std::int32_t triangle;     // index into Geometry::triangles
};

// Depth at a pixel. The plane is no exact one: beyond 0 and 1 it is clamped. -0 becomes 0, and NaN 1.
PLUMB_INLINE float depth_at(const DeviceTriangle& t, int x, int y, bool fma) {
    const float depth = min(1.0f, at(t.depth, x, y, fma));
    return depth > 0 ? depth : 0.0f;
}

// l1, l2 of the whole triangle.
PLUMB_INLINE glm::vec2 barycentrics_at(const DeviceTriangle& t, int x, int y, bool fma) {
    const float w = 1.0f / at(t.inverse_w, x, y, fma);
    return {at(t.l1, x, y, fma) * w, at(t.l2, x, y, fma) * w};
}

// Corners alone, for area2() and edge_row().
inline ScreenTriangle screen_corners(const DeviceTriangle& t) {
    ScreenTriangle s{};
    for (int i = 0; i < 3; ++i) s.x[i] = t.x[i], s.y[i] = t.y[i];
    return s;
}

// Whether there is a pixel centre between the extremes of n coordinates, in 1/256 pixel, within 0..side - 1; false for
// numbers out of any frame.
bool meets_centre(const std::int32_t* c, int n, int side);

// The columns [first, last] of a row that the triangle covers; empty: first > last.
void covered_columns(const DeviceTriangle& t, int row, int width, int& first, int& last);

// Appends what may be seen of a triangle, in the order in which the device draws it: itself, or the pieces of its
// clipped polygon. What has no area or no pixel centre in its box is left out.
void append_device_shape(std::vector<DeviceTriangle>& out, const glm::vec4 corners[3], std::int32_t triangle,
                         glm::ivec2 size, const DeviceProfile& profile);

}  // namespace plumb::raster
