#include "raster/device_triangle.h"

#include <algorithm>

namespace plumb::raster {
namespace {

constexpr int planes = 6;
constexpr int capacity = 16;  // three corners, one more a plane, and room for what rounding bends

// A vertex on its way through the device.
struct DeviceVertex {
    glm::vec4 clip;
    glm::vec2 barycentrics;
    float x, y, z;    // window: pixels, depth
    float inverse_w;
};

struct Frame {
    glm::vec2 half;  // of the frame's size, pixels
    bool fma;
};

float multiply_add(float a, float b, float c, bool fma) { return fma ? fused(a, b, c) : a * b + c; }

// The viewport, 0 to `size` and depth 0 to 1.
void project(DeviceVertex& v, const Frame& frame, bool fma) {
    v.inverse_w = 1.0f / v.clip.w;
    v.x = multiply_add(v.clip.x * v.inverse_w, frame.half.x, frame.half.x, fma);
    v.y = multiply_add(v.clip.y * v.inverse_w, frame.half.y, frame.half.y, fma);
    v.z = v.clip.z * v.inverse_w + 0.0f;
}

// One bit for each plane that the vertex is beyond.
unsigned planes_beyond(const glm::vec4& c) {
    return unsigned(c.x > c.w) | unsigned(c.x + c.w < 0) << 1 | unsigned(c.y > c.w) << 2 | unsigned(c.y + c.w < 0) << 3 |
           unsigned(c.z < 0) << 4 | unsigned(c.z > c.w) << 5;
}

// Not negative on the inner side.
float distance(const glm::vec4& c, int plane) {
    switch (plane) {
        case 0: return c.w - c.x;
        case 1: return c.x + c.w;
        case 2: return c.w - c.y;
        case 3: return c.y + c.w;
        case 4: return c.z;
        default: return c.w - c.z;
    }
}

// Where an edge meets a plane, measured from the end that is nearer to it.
DeviceVertex meet(const DeviceVertex& a, float da, const DeviceVertex& b, float db, const Frame& frame) {
    const bool from_a = !(abs(db) < abs(da));
    const DeviceVertex &near = from_a ? a : b, &far = from_a ? b : a;
    const float t = from_a ? da / (da - db) : db / (db - da);
    DeviceVertex v;
    v.clip = near.clip + t * (far.clip - near.clip);
    v.barycentrics = near.barycentrics + t * (far.barycentrics - near.barycentrics);
    project(v, frame, false);
    return v;
}

struct Polygon {
    DeviceVertex vertices[capacity];
    int count = 0;
};

Polygon clip_by(const Polygon& in, int plane, const Frame& frame) {
    Polygon out;
    for (int i = 0; i < in.count && out.count + 2 <= capacity; ++i) {
        const DeviceVertex &a = in.vertices[i], &b = in.vertices[(i + 1) % in.count];
        const float da = distance(a.clip, plane), db = distance(b.clip, plane);
        if (da >= 0) out.vertices[out.count++] = a;
        if ((da >= 0) == (db >= 0)) continue;
        // The end within comes first where both are as near.
        out.vertices[out.count++] = da >= 0 ? meet(a, da, b, db, frame) : meet(b, db, a, da, frame);
    }
    return out;
}

// The grid's nearest place, ties to even, in 1/256 pixel.
std::int32_t snapped(float window, int subpixel_bits) {
    const float grid = float(1 << subpixel_bits);
    return number<float>::round_to_index((window - 0.5f) * grid) * (256 >> subpixel_bits);
}

// The plane through a value at each corner. Its gradient is taken between unsnapped corners, its value at the
// framebuffer's origin from the first corner's.
struct PlaneSetup {
    float x0, y0;  // of the first corner, from the first pixel's centre
    float dy20, dy01, dx20, dx01;  // over twice the area

    PlaneSetup(const DeviceVertex& a, const DeviceVertex& b, const DeviceVertex& c) {
        const float x01 = a.x - b.x, y01 = a.y - b.y, x20 = c.x - a.x, y20 = c.y - a.y;
        const float inverse_area = 1.0f / (x01 * y20 - y01 * x20);
        dx01 = x01 * inverse_area, dy01 = y01 * inverse_area;
        dx20 = x20 * inverse_area, dy20 = y20 * inverse_area;
        x0 = a.x - 0.5f, y0 = a.y - 0.5f;
    }
    Plane through(float a, float b, float c) const {
        const float d01 = a - b, d20 = c - a;
        Plane p;
        p.along_x = d01 * dy20 - d20 * dy01;
        p.along_y = d20 * dx01 - d01 * dx20;
        p.at_origin = a - (p.along_x * x0 + p.along_y * y0);
        return p;
    }
};

void append(std::vector<DeviceTriangle>& out, const DeviceVertex& a, const DeviceVertex& b, const DeviceVertex& c,
            std::int32_t triangle, glm::ivec2 size, const DeviceProfile& profile) {
    DeviceTriangle t;
    const DeviceVertex* corners[3] = {&a, &b, &c};
    for (int i = 0; i < 3; ++i) {
        t.x[i] = snapped(corners[i]->x, profile.subpixel_bits);
        t.y[i] = snapped(corners[i]->y, profile.subpixel_bits);
    }
    if (!meets_centre(t.x, 3, size.x) || !meets_centre(t.y, 3, size.y) || area2(screen_corners(t)) == 0) return;
    const PlaneSetup setup(a, b, c);
    t.depth = setup.through(a.z, b.z, c.z);
    t.inverse_w = setup.through(a.inverse_w, b.inverse_w, c.inverse_w);
    auto over_w = [&](int k) {
        return setup.through(a.barycentrics[k] * a.inverse_w, b.barycentrics[k] * b.inverse_w,
                             c.barycentrics[k] * c.inverse_w);
    };
    t.l1 = over_w(0);
    t.l2 = over_w(1);
    t.triangle = triangle;
    out.push_back(t);
}

}  // namespace

bool meets_centre(const std::int32_t* c, int n, int side) {
    const std::int32_t low = *std::min_element(c, c + n), high = *std::max_element(c, c + n);
    if (low < -(1 << 24) || high > 1 << 24) return false;
    return std::max(0, (low + 255) >> 8) <= std::min(side - 1, high >> 8);
}

void covered_columns(const DeviceTriangle& t, int row, int width, int& first, int& last) {
    const ScreenTriangle corners = screen_corners(t);
    const bool clockwise = area2(corners) > 0;
    const EdgeRow edges[3] = {edge_row(corners, clockwise, 0, row), edge_row(corners, clockwise, 1, row),
                              edge_row(corners, clockwise, 2, row)};
    const int low = std::min({t.x[0], t.x[1], t.x[2]}), high = std::max({t.x[0], t.x[1], t.x[2]});
    std::int64_t begin = std::max(0, (low + 255) >> 8), end = std::min(width - 1, high >> 8);
    covered_columns(edges, begin, end);
    first = int(begin), last = int(end);
}

void append_device_shape(std::vector<DeviceTriangle>& out, const glm::vec4 corners[3], std::int32_t triangle,
                         glm::ivec2 size, const DeviceProfile& profile) {
    unsigned any = 0, all = ~0u;
    for (int i = 0; i < 3; ++i) any |= planes_beyond(corners[i]), all &= planes_beyond(corners[i]);
    if (all) return;

    const Frame frame{glm::vec2(size) * 0.5f, profile.fused_raster};
    Polygon polygon;
    polygon.count = 3;
    for (int i = 0; i < 3; ++i) {
        DeviceVertex& v = polygon.vertices[i];
        v.clip = corners[i];
        v.barycentrics = {i == 1 ? 1.0f : 0.0f, i == 2 ? 1.0f : 0.0f};
        project(v, frame, frame.fma);
    }
    for (int plane = 0; plane < planes; ++plane)
        if (any >> plane & 1) polygon = clip_by(polygon, plane, frame);
    for (int i = 2; i < polygon.count; ++i)
        append(out, polygon.vertices[0], polygon.vertices[i - 1], polygon.vertices[i], triangle, size, profile);
}

}  // namespace plumb::raster
