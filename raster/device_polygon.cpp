#include "raster/device_polygon.h"

#include <algorithm>

namespace plumb::raster {
namespace {

constexpr int planes = 6;

struct Polygon {
    glm::vec4 vertices[DevicePolygon::capacity];
    int count = 0;
};

// Not negative on the inner side.
float distance(const glm::vec4& c, int plane) {
    switch (plane) {
        case 0: return c.z;
        case 1: return c.w - c.z;
        case 2: return c.w + c.x;
        case 3: return c.w - c.x;
        case 4: return c.w + c.y;
        default: return c.w - c.y;
    }
}

// One bit for each plane that the vertex is beyond.
unsigned planes_beyond(const glm::vec4& c) {
    return unsigned(c.z < 0) | unsigned(c.w < c.z) << 1 | unsigned(-c.w > c.x) << 2 | unsigned(c.w < c.x) << 3 |
           unsigned(-c.w > c.y) << 4 | unsigned(c.w < c.y) << 5;
}

Polygon clip_by(const Polygon& in, int plane) {
    Polygon out;
    for (int i = 0; i < in.count && out.count + 2 <= DevicePolygon::capacity; ++i) {
        const glm::vec4 &a = in.vertices[i], &b = in.vertices[(i + 1) % in.count];
        const float da = distance(a, plane), db = distance(b, plane);
        if (da >= 0) out.vertices[out.count++] = a;
        // Always seen from the inner end.
        if (da >= 0 && db < 0) out.vertices[out.count++] = (db * a - da * b) * (1.0f / (db - da));
        if (da < 0 && db > 0) out.vertices[out.count++] = (da * b - db * a) * (1.0f / (da - db));
    }
    return out;
}

float inverse(float w) { return 1.0f / (w == 0 ? 1.0f : w); }

// In units of the grid, from the first pixel's centre.
glm::ivec2 snapped(const glm::vec4& c, glm::ivec2 size, float grid) {
    const float half_width = float(size.x) * 0.5f * grid, half_height = float(size.y) * 0.5f * grid;
    const float r = inverse(c.w), centre = grid * 0.5f;
    return {number<float>::round_to_index((half_width - centre) + c.x * r * half_width),
            number<float>::round_to_index((half_height - centre) + c.y * r * half_height)};
}

// The corner that planes are anchored at comes first: the one with the largest w; of equal ones the uppermost.
struct Order {
    int at[3] = {0, 1, 2};

    void turn(int first) {
        const int old[3] = {at[0], at[1], at[2]};
        for (int i = 0; i < 3; ++i) at[i] = old[(i + first) % 3];
    }
    // Turns by both conditions, each asked before any turn: where all three are equal nothing moves.
    void bring_first(bool second, bool third) {
        if (second) turn(1);
        if (third) turn(2);
    }
};
Order anchored_first(const glm::vec4 corners[3]) {
    Order o;
    const float top = std::min({corners[0].y, corners[1].y, corners[2].y});
    o.bring_first(top == corners[1].y, top == corners[2].y);
    const float w[3] = {corners[o.at[0]].w, corners[o.at[1]].w, corners[o.at[2]].w};
    const float most = std::max({w[0], w[1], w[2]});
    o.bring_first(most == w[1], most == w[2]);
    return o;
}

void set_planes(DevicePolygon& p, const glm::vec4 corners[3], const glm::ivec2 places[3], float grid) {
    const Order order = anchored_first(corners);
    const glm::vec4 &a = corners[order.at[0]], &b = corners[order.at[1]], &c = corners[order.at[2]];
    const glm::ivec2 place = places[order.at[0]];
    const glm::vec2 to_b = places[order.at[1]] - place, to_c = places[order.at[2]] - place;  // grid
    const float pixel = 1.0f / grid;
    p.anchor_x = float(place.x) * pixel, p.anchor_y = float(place.y) * pixel;

    // Depth is affine in the window.
    const float x1 = to_b.x * pixel, y1 = to_b.y * pixel, x2 = to_c.x * pixel, y2 = to_c.y * pixel;
    const float z0 = a.z * inverse(a.w), z1 = b.z * inverse(b.w) - z0, z2 = c.z * inverse(c.w) - z0;
    const float over_area = 1.0f / (x1 * y2 - x2 * y1);
    p.depth = {z0, over_area * (y2 * z1 - y1 * z2), over_area * (x1 * z2 - x2 * z1)};

    // The share of each corner, over w (Olano and Greer 1997, "Triangle Scan Conversion using 2D Homogeneous
    // Coordinates"); their sum is 1/w.
    const float wx1 = b.w * pixel * to_b.x, wy1 = b.w * pixel * to_b.y;
    const float wx2 = c.w * pixel * to_c.x, wy2 = c.w * pixel * to_c.y;
    const float determinant = wx1 * wy2 - wx2 * wy1;
    Plane share[3] = {{inverse(a.w), 0, 0}, {0, 0, 0}, {0, 0, 0}};
    if (determinant != 0) {
        const float over = 1.0f / determinant, over_w = over * inverse(a.w);
        share[0].along_x = (wy1 * c.w - wy2 * b.w) * over_w, share[0].along_y = (wx2 * b.w - wx1 * c.w) * over_w;
        share[1].along_x = wy2 * over, share[1].along_y = -wx2 * over;
        share[2].along_x = -wy1 * over, share[2].along_y = wx1 * over;
    }
    auto blend = [&](float v0, float v1, float v2) -> Plane {
        auto sum = [&](float Plane::*m) { return (v0 * share[0].*m + v1 * share[1].*m) + v2 * share[2].*m; };
        return {sum(&Plane::at_origin), sum(&Plane::along_x), sum(&Plane::along_y)};
    };
    auto one_at = [&](int corner) {
        return blend(order.at[0] == corner ? 1.0f : 0.0f, order.at[1] == corner ? 1.0f : 0.0f,
                     order.at[2] == corner ? 1.0f : 0.0f);
    };
    p.inverse_w = blend(1, 1, 1);
    p.l1 = one_at(1);
    p.l2 = one_at(2);
}

bool turns_clockwise(const glm::vec4 corners[3], const glm::ivec2 places[3]) {
    const glm::vec2 a(places[0]), b(places[1]), c(places[2]);
    const float area = (a.y - c.y) * b.x + (c.y - b.y) * a.x + (b.y - a.y) * c.x;
    return (corners[0].w * corners[1].w * corners[2].w < 0 ? -area : area) > 0;
}

}  // namespace

void covered_columns(const DevicePolygon& p, int row, int width, int& first, int& last) {
    std::int64_t left = 0, right = 0;
    for (int i = 0; i < p.count; ++i) {
        const int j = (i + 1) % p.count, from = p.turned ? i : j, to = p.turned ? j : i;
        const int upper = p.y[from] < p.y[to] ? from : to, lower = upper == from ? to : from;
        const std::int64_t height = p.y[lower] - p.y[upper], down = 256 * std::int64_t(row) - p.y[upper];
        if (down < 0 || down >= height) continue;
        // The first centre that is not left of the edge.
        const std::int64_t along = std::int64_t(p.x[lower] - p.x[upper]) * down + p.x[upper] * height;
        const std::int64_t unit = 256 * height, column = along / unit + (along % unit > 0);
        (upper == to ? left : right) = std::min(std::max(column, std::int64_t(0)), std::int64_t(width));
    }
    first = int(left), last = int(right) - 1;
}

void append_device_shape(std::vector<DevicePolygon>& out, const glm::vec4 corners[3], std::int32_t triangle,
                         glm::ivec2 size, const DeviceProfile& profile) {
    unsigned any = 0, all = ~0u;
    for (int i = 0; i < 3; ++i) any |= planes_beyond(corners[i]), all &= planes_beyond(corners[i]);
    if (all) return;
    Polygon polygon;
    polygon.count = 3;
    std::copy(corners, corners + 3, polygon.vertices);
    for (int plane = 0; plane < planes; ++plane)
        if (any >> plane & 1) polygon = clip_by(polygon, plane);
    if (polygon.count < 3) return;

    DevicePolygon p;
    p.count = polygon.count;
    const float grid = float(1 << profile.subpixel_bits);
    for (int i = 0; i < p.count; ++i) {
        const glm::ivec2 place = snapped(polygon.vertices[i], size, grid) * (256 >> profile.subpixel_bits);
        p.x[i] = place.x, p.y[i] = place.y;
    }
    if (!meets_centre(p.x, p.count, size.x) || !meets_centre(p.y, p.count, size.y)) return;
    const glm::ivec2 places[3] = {snapped(corners[0], size, grid), snapped(corners[1], size, grid),
                                  snapped(corners[2], size, grid)};
    p.turned = !turns_clockwise(corners, places);
    p.triangle = triangle;
    set_planes(p, corners, places, grid);
    out.push_back(p);
}

}  // namespace plumb::raster
