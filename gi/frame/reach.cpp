// What a light or a camera may reach of a box: exact in real numbers, and wrong, if at all, on the side of "it may". See
// gi/frame/README.md.
#include <algorithm>
#include <cmath>

#include "core/host_math.h"
#include "gi/frame/rules.h"
#include "raster/light_view.h"

namespace plumb::frame {

namespace {

double dot(const glm::dvec3& a, const glm::dvec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

glm::dvec3 corner_of(const Box& box, int i) {
    return {i & 1 ? box.high.x : box.low.x, i & 2 ? box.high.y : box.low.y, i & 4 ? box.high.z : box.low.z};
}

// A solid cone, its tip at the origin.
struct Cone {
    glm::dvec3 axis;      // unit
    double cosine2 = 0;   // of the half angle, squared; the half angle is below 90 degrees

    // Not negative inside, where also dot(axis, v) >= 0.
    double inside(const glm::dvec3& v) const {
        const double along = dot(axis, v);
        return along * along - cosine2 * dot(v, v);
    }
};

// Whether a segment meets the cone. In front of the tip the points inside are an interval of the segment: it has one of
// the ends, or, where `inside` bends down along the segment, the point where that is largest.
bool meets(const Cone& cone, glm::dvec3 a, glm::dvec3 b) {
    double da = dot(cone.axis, a), db = dot(cone.axis, b);
    if (da < 0 && db < 0) return false;
    if (da < 0) std::swap(a, b), std::swap(da, db);
    // Cut off what lies behind the tip.
    if (db < 0) b = a + (b - a) * (da / (da - db));
    if (cone.inside(a) >= 0 || cone.inside(b) >= 0) return true;
    const glm::dvec3 d = b - a;
    const double ad = dot(cone.axis, d);
    const double bend = ad * ad - cone.cosine2 * dot(d, d);
    const double slope = dot(cone.axis, a) * ad - cone.cosine2 * dot(a, d);
    if (!(bend < 0)) return false;
    const double t = slope / -bend;
    return t > 0 && t < 1 && cone.inside(a + d * t) >= 0;
}

// Whether the ray from the origin along `direction` meets the box.
bool ray_meets(const glm::dvec3& direction, const Box& box) {
    double first = 0, last = unbounded;
    for (int c = 0; c < 3; ++c) {
        if (direction[c] == 0) {
            if (box.low[c] > 0 || box.high[c] < 0) return false;
            continue;
        }
        const double a = box.low[c] / direction[c], b = box.high[c] / direction[c];
        first = std::max(first, std::min(a, b)), last = std::min(last, std::max(a, b));
    }
    return first <= last;
}

// Two convex bodies, of which the cone ends nowhere: where they meet, an edge of the box meets the cone, or the section
// of a face with the cone lies within the face, and the axis goes through it.
bool meets(const Cone& cone, const Box& box) {
    if (ray_meets(cone.axis, box)) return true;
    for (int i = 0; i < 8; ++i)
        for (int c = 0; c < 3; ++c)
            if (!(i >> c & 1) && meets(cone, corner_of(box, i), corner_of(box, i | 1 << c))) return true;
    return false;
}

// The cone that a kernel in float, or a map of so many texels, may take a spot's for: an edge of a triangle is snapped
// to 1/256 of a texel, and a cosine of two floats is off by less than 2e-6.
Cone cone_of(const Light& light, const glm::dvec3& direction) {
    const double tangent = host::tan(light.cone_outer_deg * (host::pi / 180)) * (1 + 1.0 / (64.0 * light.rsm_size));
    const double cosine = std::max(1 / std::sqrt(1 + tangent * tangent) - 2e-6, 0.0);
    return {direction, cosine * cosine};
}

double largest(const glm::dvec3& v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

}  // namespace

Box grown(const Box& box, double by) { return {box.low - glm::dvec3(by), box.high + glm::dvec3(by)}; }

bool may_light(const Light& light, const Box& box) {
    if (light.type != LightType::spot) return true;
    const glm::dvec3 d(light.direction), tip(light.position);
    const double length = std::sqrt(dot(d, d));
    // What light_view() refuses is not judged here.
    if (!(light.cone_outer_deg > 0 && light.cone_outer_deg < 89.9 && length > 1e-30 && length < 1e30)) return true;
    return meets(cone_of(light, d / length), Box{box.low - tip, box.high - tip});
}

bool may_see(const Scene& scene, const Box& box) {
    const glm::ivec2 size = scene.frame_size;
    const View view = make_view(scene.camera, double(size.x) / size.y, scene.convention, size);
    // Half a pixel around the frame sees nothing; that and this are more than rounding.
    const double by = 0x1p-20 * std::max({largest(box.low), largest(box.high), largest(view.eye)});
    const Box wide = grown(box, by);
    double nearest = unbounded, farthest = -unbounded;
    for (int i = 0; i < 8; ++i) {
        const double depth = dot(view.forward, corner_of(wide, i) - view.eye);
        nearest = std::min(nearest, depth), farthest = std::max(farthest, depth);
    }
    if (farthest < scene.camera.near || nearest > scene.camera.far) return false;
    return raster::may_see(view, glm::vec3(wide.low), glm::vec3(wide.high));
}

}  // namespace plumb::frame
