#include "raster/clip.h"

namespace plumb::raster {
namespace {

constexpr int planes = 6;

// Not negative on the inner side of the plane.
double distance(const ClipVolume& volume, const glm::dvec4& p, int plane) {
    switch (plane) {
        case 0: return p.z;
        case 1: return p.w - p.z;
        case 2: return volume.guard.x * p.w + p.x;
        case 3: return volume.guard.x * p.w - p.x;
        case 4: return volume.guard.y * p.w + p.y;
        default: return volume.guard.y * p.w - p.y;
    }
}

// Where the edge meets the plane, always seen from its inner end, so that both triangles of an edge find the same
// point. The weighted sum keeps each component's relative error near 2^-53 where a + t (b - a) would cancel: products
// of two floats are exact in double.
ClipVertex meet(const ClipVertex& inner, double inner_distance, const ClipVertex& outer, double outer_distance) {
    const double range = inner_distance - outer_distance;
    ClipVertex v;
    for (int c = 0; c < 4; ++c)
        v.position[c] = (inner_distance * outer.position[c] - outer_distance * inner.position[c]) / range;
    for (int c = 0; c < 2; ++c)
        v.barycentrics[c] = (inner_distance * outer.barycentrics[c] - outer_distance * inner.barycentrics[c]) / range;
    return v;
}

ClipPolygon clip_by(const ClipVolume& volume, const ClipPolygon& in, int plane) {
    ClipPolygon out;
    for (int i = 0; i < in.count; ++i) {
        const ClipVertex &a = in.vertices[i], &b = in.vertices[(i + 1) % in.count];
        const double da = distance(volume, a.position, plane), db = distance(volume, b.position, plane);
        if (da >= 0) out.vertices[out.count++] = a;
        if ((da >= 0) != (db >= 0)) {
            // Rounding may bend a polygon that was convex; what would exceed the capacity is no wider than a rounding.
            if (out.count == ClipPolygon::capacity) break;
            out.vertices[out.count++] = da >= 0 ? meet(a, da, b, db) : meet(b, db, a, da);
        }
        if (out.count == ClipPolygon::capacity) break;
    }
    return out;
}

}  // namespace

ClipVolume clip_volume(glm::ivec2 size) {
    // Window x is (x / w + 1) width / 2: it is 65,536 where x / w is 2^17 / width - 1.
    return {{0x1p17 / size.x - 1, 0x1p17 / size.y - 1}};
}

bool outside_frame(const glm::vec4 corners[3]) {
    const ClipVolume frame;
    for (int plane = 0; plane < planes; ++plane) {
        int beyond = 0;
        for (int i = 0; i < 3; ++i) beyond += distance(frame, glm::dvec4(corners[i]), plane) < 0;
        if (beyond == 3) return true;
    }
    return false;
}

bool inside(const ClipVolume& volume, const glm::vec4& corner) {
    for (int plane = 0; plane < planes; ++plane)
        if (distance(volume, glm::dvec4(corner), plane) < 0) return false;
    return corner.w > 0;
}

ClipPolygon clip(const ClipVolume& volume, const glm::vec4 corners[3]) {
    ClipPolygon polygon;
    polygon.count = 3;
    for (int i = 0; i < 3; ++i)
        polygon.vertices[i] = {glm::dvec4(corners[i]), {i == 1 ? 1.0 : 0.0, i == 2 ? 1.0 : 0.0}};
    for (int plane = 0; plane < planes && polygon.count > 0; ++plane) polygon = clip_by(volume, polygon, plane);

    // Within 0 <= z <= w, w is zero at the viewer itself only: nothing can be seen of what touches it there.
    for (int i = 0; i < polygon.count; ++i)
        if (!(polygon.vertices[i].position.w > 0)) polygon.count = 0;
    return polygon;
}

}  // namespace plumb::raster
