// Where a device places the corners of triangles, who owns what lies on an edge, and what it makes of depth and
// attributes.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/hash.h"
#include "raster/device_raster.h"
#include "tools/vulkan/graphics.h"
#include "tools/vulkan/probe.h"
#include "tools/vulkan/twins.h"

namespace plumb::vulkan {
namespace {

Spirv embedded(const char* name) {
    const Twin twin = find_twin(name);
    return {twin.spirv.begin(), twin.spirv.end()};
}

DrawnTriangles draw(const Device& device, glm::ivec2 size, std::vector<glm::vec4> corners) {
    const Targets targets = make_targets(device, {std::uint32_t(size.x), std::uint32_t(size.y)},
                                         {VK_FORMAT_R32_SINT, VK_FORMAT_R32G32_SFLOAT});
    GraphicsOptions options;
    options.vertex_shader = embedded("tools/probe/triangles.vert");
    options.fragment_shader = embedded("tools/probe/triangles.frag");
    options.name = "tools/probe/triangles";
    options.stride = sizeof(glm::vec4);
    options.attributes = {{VK_FORMAT_R32G32B32A32_SFLOAT, 0}};
    const GraphicsPipeline pipeline = make_graphics_pipeline(device, targets, options);
    const Buffer vertices = device_buffer(device, corners.data(), corners.size() * sizeof corners[0],
                                          VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
    device.run([&](VkCommandBuffer commands) {
        targets.begin(commands);
        pipeline.bind(commands);
        const VkBuffer buffer = vertices.get();
        const VkDeviceSize offset = 0;
        vkCmdBindVertexBuffers(commands, 0, 1, &buffer, &offset);
        vkCmdDraw(commands, std::uint32_t(corners.size()), 1, 0, 0);
        targets.end(commands);
    });
    raster::VisibilityBuffer drawn{plumb::Image<std::int32_t>(size.x, size.y), Image1(size.x, size.y),
                                   plumb::Image<glm::vec2>(size.x, size.y)};
    read_image(device, targets.colours[0], drawn.triangle.data(), drawn.triangle.size() * 4);
    read_image(device, targets.colours[1], drawn.barycentrics.data(), drawn.barycentrics.size() * 8);
    read_image(device, targets.depth, drawn.depth.data(), drawn.depth.size() * 4);
    for (std::int32_t& t : drawn.triangle.texels) --t;
    return {size, std::move(corners), std::move(drawn)};
}

// The same by a profile.
raster::VisibilityBuffer draw_here(const DrawnTriangles& in, const DeviceProfile& profile) {
    Geometry geometry;
    plumb::Buffer<glm::vec4> positions(in.corners.begin(), in.corners.end());
    geometry.vertices.resize(in.corners.size());
    for (unsigned i = 0; i < in.corners.size(); i += 3) geometry.triangles.push_back({i, i + 1, i + 2});
    geometry.material.assign(geometry.triangles.size(), 0);
    geometry.object.assign(geometry.triangles.size(), 0);
    raster::VisibilityBuffer out;
    raster::draw_device_visibility(geometry, nullptr, positions, false, in.size, profile, {}, out);
    return out;
}

bool same(float a, float b) {
    return number<float>::bits(a) == number<float>::bits(b) || (a != a && b != b);
}

// ---- Snapping -------------------------------------------------------------------------------------------------------

constexpr int corners_tried = 256, centres = 4096;  // the frame: a column a corner

// Triangle k has corners (k + 1/4, 0), (k + 3/4 + offset, 4096) and (k + 15/16, 0) in pixels: its left edge crosses the
// column of centres at k + 1/2 between rows 1820 and 2340.
double offset(int k) { return (k - corners_tried / 2) * 0x1p-11; }

std::vector<glm::vec4> snapping_corners() {
    std::vector<glm::vec4> out;
    for (int k = 0; k < corners_tried; ++k)
        for (const glm::dvec2& p : {glm::dvec2(k + 0.25, 0), glm::dvec2(k + 0.75 + offset(k), centres),
                                    glm::dvec2(k + 0.9375, 0)})
            out.push_back({float(p.x * 2 / corners_tried - 1), float(p.y * 2 / centres - 1), 0.5f, 1});
    return out;
}

struct Rounding {
    const char* name;
    double (*round)(double);
};
constexpr Rounding roundings[] = {{"to even", [](double x) { return __builtin_rint(x); }},
                                  {"up", [](double x) { return __builtin_floor(x + 0.5); }},
                                  {"down", [](double x) { return __builtin_ceil(x - 0.5); }},
                                  {"towards zero", [](double x) { return __builtin_floor(x); }}};

// How many centres of column k are covered, if corners lie on a grid of 2^-bits: from the first row on.
int covered_rows(int k, int bits, const Rounding& rounding) {
    auto snapped = [&](double x) { return std::int64_t(rounding.round(std::ldexp(x, bits))); };
    const std::int64_t a = snapped(k + 0.25), b = snapped(k + 0.75 + offset(k)), c = snapped(k + 0.9375);
    const std::int64_t centre = (2 * k + 1) * (std::int64_t(1) << (bits - 1));
    int rows = 0;
    for (std::int64_t y = 1; y < 2 * centres; y += 2)  // in half rows
        rows += a * 2 * centres + (b - a) * y <= centre * 2 * centres &&
                c * 2 * centres + (b - c) * y > centre * 2 * centres;
    return rows;
}

SnappingFigures find_snapping(const DrawnTriangles& t) {
    SnappingFigures out;
    int rows[corners_tried] = {};
    for (int k = 0; k < corners_tried; ++k) {
        for (int y = 0; y < centres; ++y) rows[k] += t.drawn.triangle(k, y) == k;
        const double seen = 0.25 * centres / std::max(rows[k], 1) - 0.5;
        out.displacement = std::max(out.displacement, std::abs(seen - offset(k)));
    }
    for (int bits = 1; bits <= 10; ++bits)
        for (const Rounding& rounding : roundings) {
            bool all = true;
            for (int k = 0; k < corners_tried && all; ++k) all = covered_rows(k, bits, rounding) == rows[k];
            if (!all) continue;
            out.bits = bits, out.ties = rounding.name;
            return out;
        }
    return out;
}

// ---- Triangles of a hash --------------------------------------------------------------------------------------------

struct Stream {
    int item, seed;
    int next = 0;
    float between(float low, float high) {
        const auto h = pixel_hash<std::int32_t>(item, next++, 0, seed);
        return low + (high - low) * unit_float<float>(h.x);
    }
    int below(int n) { return int(between(0, float(n))); }
};

// Corners on multiples of half a pixel, all at one depth: the first triangle that owns a centre stays.
std::vector<glm::vec4> shared_edge_corners(int side, int triangles) {
    std::vector<glm::vec4> out;
    for (int t = 0; t < triangles; ++t) {
        Stream s{t, 5};
        const int x = 12 + s.below(2 * side - 24), y = 12 + s.below(2 * side - 24);
        for (int c = 0; c < 3; ++c)
            out.push_back({float(x + s.below(24) - 12) / float(side) - 1, float(y + s.below(24) - 12) / float(side) - 1,
                           0.5f, 1});
    }
    return out;
}

// Triangles of up to `extent` of the frame. Within: nothing is clipped. Otherwise some corners lie beyond each plane,
// the viewer's too.
std::vector<glm::vec4> hashed_corners(int triangles, bool within, int seed) {
    std::vector<glm::vec4> out;
    for (int t = 0; t < triangles; ++t) {
        Stream s{t, seed};
        const float extent = within ? s.between(0.01f, 0.3f) : s.between(0.1f, 1.5f);
        const float x = s.between(-0.7f, 0.7f), y = s.between(-0.7f, 0.7f);
        for (int c = 0; c < 3; ++c) {
            const float w = within ? s.between(0.5f, 4) : s.between(-0.5f, 4);
            const float z = within ? s.between(0, 1) : s.between(-0.3f, 1.3f);
            const float along_x = s.between(-extent, extent), along_y = s.between(-extent, extent);
            out.push_back({(x + along_x) * w, (y + along_y) * w, z * w, w});
        }
    }
    return out;
}

}  // namespace

RasterDifferences compare_drawing(const DrawnTriangles& triangles, const DeviceProfile& profile) {
    const raster::VisibilityBuffer ours = draw_here(triangles, profile);
    const raster::VisibilityBuffer& theirs = triangles.drawn;
    RasterDifferences out;
    for (std::size_t i = 0; i < ours.triangle.size(); ++i) {
        const glm::vec2 &a = ours.barycentrics.texels[i], &b = theirs.barycentrics.texels[i];
        out.pixels += theirs.triangle.texels[i] >= 0;
        if (ours.triangle.texels[i] != theirs.triangle.texels[i]) {
            ++out.triangle;
            continue;
        }
        out.depth += !same(ours.depth.texels[i], theirs.depth.texels[i]);
        out.barycentrics += !(same(a.x, b.x) && same(a.y, b.y));
    }
    return out;
}

void probe_rasterisation(const Device& device, Probe& probe) {
    probe.snapping = find_snapping(draw(device, {corners_tried, centres}, snapping_corners()));
    const DrawnTriangles shared = draw(device, {128, 128}, shared_edge_corners(128, 2000));
    probe.shared_edges = compare_drawing(shared, DeviceProfile{}).triangle;
    // Sides that are no powers of two, where a fused multiply-add shows in window positions.
    probe.inside = draw(device, {200, 142}, hashed_corners(1500, true, 6));
    probe.clipped = draw(device, {200, 142}, hashed_corners(600, false, 7));
}

}  // namespace plumb::vulkan
