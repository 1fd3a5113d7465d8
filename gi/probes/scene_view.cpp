#include "gi/probes/scene_view.h"

#include <algorithm>
#include <cmath>

#include "core/host_math.h"

namespace plumb::probes {

SceneView::SceneView(const Atlas& atlas, const raster::Surfaces& surfaces, const View& view, glm::ivec2 size, const RunOptions& options)
    : atlas_(atlas), view_(view), size_(size), to_world_(glm::inverse(view.world_to_clip())) {
    raster::GBufferWants wants;
    wants.albedo = wants.emission = false;
    raster::draw_gbuffer(atlas.geometry, surfaces, view, size, raster::Layout::fp32, options, seen_, wants);
}

Image4 SceneView::with(const Image4* lightmap) const {
    Image4 picture(size_.x, size_.y, nothing);
    for (int y = 0; y < size_.y; ++y)
        for (int x = 0; x < size_.x; ++x) {
            if (seen_.id(x, y).y < 0) continue;
            const glm::dvec3 n(seen_.normal(x, y)), p(seen_.position(x, y));
            const double facing = std::fabs(glm::dot(n, glm::normalize(view_.eye - p)));
            const glm::vec4 base = lightmap ? texel_at(*lightmap, seen_.id(x, y).y, p) : grey;
            picture(x, y) = glm::vec4(glm::vec3(base) * float(0.4 + 0.6 * facing), 1);
        }
    return picture;
}

void SceneView::ball(Image4& picture, const glm::dvec3& centre, double radius, const glm::vec4& colour) const {
    glm::ivec2 low, high;
    if (!pixels_of(centre, radius, low, high)) return;
    for (int y = low.y; y <= high.y; ++y)
        for (int x = low.x; x <= high.x; ++x) {
            const glm::dvec3 direction = ray(x, y), to = centre - view_.eye;
            const double along = glm::dot(to, direction), d2 = glm::dot(to, to) - along * along;
            if (d2 > radius * radius || along <= 0) continue;
            const double depth = (along - std::sqrt(radius * radius - d2)) * glm::dot(direction, view_.forward);
            const bool hidden = seen_.id(x, y).y >= 0 && double(seen_.position(x, y).w) < depth;
            if (!hidden) picture(x, y) = colour * float(1 - 0.7 * d2 / (radius * radius));
        }
}

void SceneView::outline(Image4& picture, const glm::dvec3& centre, double radius, const glm::vec4& colour) const {
    for (int k = 0; k < 720; ++k) {
        const double a = 2 * host::pi * k / 720;
        const glm::dvec3 side = glm::dvec3(glm::transpose(view_.world_to_view) * glm::dvec4(host::cos(a), host::sin(a), 0, 0));
        glm::dvec2 at;
        if (pixel_of(centre + radius * side, at)) put(picture, at, colour);
    }
}

void SceneView::line(Image4& picture, const glm::dvec3& a, const glm::dvec3& b, const glm::vec4& colour) const {
    const int steps = 2 * std::max(size_.x, size_.y);
    for (int k = 0; k <= steps; ++k) {
        const glm::dvec3 p = a + (b - a) * (double(k) / steps);
        glm::dvec2 at;
        if (pixel_of(p, at) && in_front(p, at)) put(picture, at, colour);
    }
}

int SceneView::in_sight(const Buffer<glm::vec4>& points) const {
    int best = 0;
    double nearest = 1e30;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const glm::dvec3 p(points[i]);
        glm::dvec2 at;
        if (!pixel_of(p, at)) continue;
        const double off = glm::length(at - 0.5 * glm::dvec2(size_));
        if (off < nearest && in_front(p, at)) nearest = off, best = int(i);
    }
    return best;
}

bool SceneView::in_front(const glm::dvec3& p, const glm::dvec2& at) const {
    const int x = int(std::floor(at.x)), y = int(std::floor(at.y));
    if (x < 0 || y < 0 || x >= size_.x || y >= size_.y) return false;
    const double depth = glm::dot(p - view_.eye, view_.forward);
    return seen_.id(x, y).y < 0 || double(seen_.position(x, y).w) >= depth * 0.999;
}

glm::dvec3 SceneView::ray(int x, int y) const {
    const glm::dvec4 far = to_world_ * glm::dvec4(2 * (x + 0.5) / size_.x - 1, 2 * (y + 0.5) / size_.y - 1, 0.5, 1);
    return glm::normalize(glm::dvec3(far) / far.w - view_.eye);
}

bool SceneView::pixel_of(const glm::dvec3& p, glm::dvec2& at) const {
    const glm::dvec4 clip = view_.world_to_clip() * glm::dvec4(p, 1);
    if (clip.w <= 0) return false;
    at = {(clip.x / clip.w + 1) / 2 * size_.x, (clip.y / clip.w + 1) / 2 * size_.y};
    return at.x > -1e6 && at.x < 1e6 && at.y > -1e6 && at.y < 1e6;
}

bool SceneView::pixels_of(const glm::dvec3& centre, double radius, glm::ivec2& low, glm::ivec2& high) const {
    glm::dvec2 at, beside;
    const glm::dvec3 right(glm::transpose(view_.world_to_view) * glm::dvec4(1, 0, 0, 0));
    if (!pixel_of(centre, at) || !pixel_of(centre + radius * right, beside)) return false;
    const double reach = 1.5 * glm::length(beside - at) + 1;
    low = {std::max(0, int(at.x - reach)), std::max(0, int(at.y - reach))};
    high = {std::min(size_.x - 1, int(at.x + reach)), std::min(size_.y - 1, int(at.y + reach))};
    return true;
}

void SceneView::put(Image4& picture, const glm::dvec2& at, const glm::vec4& colour) const {
    const int x = int(at.x), y = int(at.y);
    if (at.x >= 0 && at.y >= 0 && x < size_.x && y < size_.y) picture(x, y) = colour;
}

glm::vec4 SceneView::texel_at(const Image4& lightmap, int triangle, const glm::dvec3& p) const {
    if (atlas_.chart[std::size_t(triangle)] < 0) return grey;
    const Geometry& g = atlas_.geometry;
    const glm::uvec3 t = g.triangles[std::size_t(triangle)];
    const glm::dvec3 a(g.vertices[t.x].position), e1 = glm::dvec3(g.vertices[t.y].position) - a,
                     e2 = glm::dvec3(g.vertices[t.z].position) - a, n = glm::cross(e1, e2);
    const double area2 = glm::dot(n, n);
    if (area2 == 0) return nothing;
    const double l1 = glm::dot(glm::cross(p - a, e2), n) / area2, l2 = glm::dot(glm::cross(e1, p - a), n) / area2;
    const glm::dvec2 ua(atlas_.uv[t.x]), ub(atlas_.uv[t.y]), uc(atlas_.uv[t.z]);
    const glm::dvec2 uv = ua + l1 * (ub - ua) + l2 * (uc - ua);
    const int x = std::clamp(int(uv.x * lightmap.width), 0, lightmap.width - 1),
              y = std::clamp(int(uv.y * lightmap.height), 0, lightmap.height - 1);
    return lightmap(x, y);
}

}  // namespace plumb::probes
