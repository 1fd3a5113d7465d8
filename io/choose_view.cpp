#include "io/choose_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "core/host_math.h"

namespace plumb::io {
namespace {

struct Sphere {
    glm::dvec3 centre{0};
    double radius = 1;
};

// Around the bounds; a scene without extent gets a metre.
Sphere sphere_around(const Geometry& geometry) {
    glm::vec3 low, high;
    if (!bounds(geometry, low, high)) return {};
    const glm::dvec3 half = (glm::dvec3(high) - glm::dvec3(low)) * 0.5;
    const double radius = std::sqrt(half.x * half.x + half.y * half.y + half.z * half.z);
    return {glm::dvec3(low) + half, radius > 0 ? radius : 1};
}

constexpr int rays_a_side = 16;
constexpr double unseen = std::numeric_limits<double>::infinity();

// What rays through the middles of 16 x 16 cells of the frame meet first, near to far.
class Look {
  public:
    Look(const Camera& camera, glm::ivec2 frame) : camera_(camera), axes_(axes(camera)) {
        height_ = host::tan(camera.fov_y_deg * (host::pi / 360));
        width_ = height_ * frame.x / frame.y;
        depth_.fill(unseen);
    }

    // The distances of what is seen, m, the nearest first.
    std::vector<double> distances(const Geometry& geometry) {
        for (const glm::uvec3& t : geometry.triangles)
            add(in_view(geometry.vertices[t.x]), in_view(geometry.vertices[t.y]), in_view(geometry.vertices[t.z]));
        std::vector<double> seen;
        for (int i = 0; i < rays_a_side * rays_a_side; ++i) {
            if (!(depth_[std::size_t(i)] < unseen)) continue;
            const glm::dvec3 d = ray(i % rays_a_side, i / rays_a_side);
            seen.push_back(depth_[std::size_t(i)] * std::sqrt(d.x * d.x + d.y * d.y + 1));
        }
        std::sort(seen.begin(), seen.end());
        return seen;
    }

  private:
    static double dot(const glm::dvec3& a, const glm::dvec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
    static glm::dvec3 cross(const glm::dvec3& a, const glm::dvec3& b) {
        return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
    }
    // x right, y up, z ahead.
    glm::dvec3 in_view(const Vertex& v) const {
        const glm::dvec3 p = glm::dvec3(v.position) - camera_.position;
        return {dot(p, axes_.right), dot(p, axes_.up), dot(p, axes_.forward)};
    }
    // Of depth 1.
    glm::dvec3 ray(int column, int row) const {
        return {width_ * ((2 * column + 1.0) / rays_a_side - 1), height_ * ((2 * row + 1.0) / rays_a_side - 1), 1};
    }
    // The cell at or after `x`, -1 to 1 over the frame.
    static int cell(double x) { return int(std::ceil((std::clamp(x, -1.0, 1.0) + 1) * (rays_a_side / 2) - 0.5)); }

    void add(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
        if (a.z <= 0 && b.z <= 0 && c.z <= 0) return;
        glm::ivec2 first(0), end(rays_a_side);
        if (a.z > 0 && b.z > 0 && c.z > 0) {
            const double x[3] = {a.x / a.z, b.x / b.z, c.x / c.z}, y[3] = {a.y / a.z, b.y / b.z, c.y / c.z};
            // One cell more, for what rounding moves.
            first = {cell(*std::min_element(x, x + 3) / width_) - 1, cell(*std::min_element(y, y + 3) / height_) - 1};
            end = {cell(*std::max_element(x, x + 3) / width_) + 1, cell(*std::max_element(y, y + 3) / height_) + 1};
        }
        for (int row = std::max(first.y, 0); row < std::min(end.y, rays_a_side); ++row)
            for (int column = std::max(first.x, 0); column < std::min(end.x, rays_a_side); ++column)
                meet(depth_[std::size_t(row * rays_a_side + column)], ray(column, row), a, b, c);
    }

    // Moeller, Trumbore 1997, "Fast, Minimum Storage Ray/Triangle Intersection", of a ray from the origin.
    void meet(double& depth, const glm::dvec3& d, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) const {
        const glm::dvec3 u = b - a, v = c - a, p = cross(d, v), q = cross(a, u);
        const double determinant = dot(u, p);
        if (!(std::fabs(determinant) > 0)) return;
        const double s = -dot(a, p) / determinant, t = -dot(d, q) / determinant, z = -dot(v, q) / determinant;
        if (s >= 0 && t >= 0 && s + t <= 1 && z >= camera_.near && z <= camera_.far) depth = std::min(depth, z);
    }

    const Camera& camera_;
    CameraAxes axes_;
    double width_, height_;  // half the frame's, at depth 1
    std::array<double, std::size_t(rays_a_side * rays_a_side)> depth_;
};

bool inside(const glm::dvec3& p, const Geometry& geometry) {
    glm::vec3 low, high;
    if (!bounds(geometry, low, high)) return false;
    for (int i = 0; i < 3; ++i)
        if (!(p[i] > low[i] && p[i] < high[i])) return false;
    return true;
}

// Where walls may stand between any other light and what the camera sees: a light at the camera has no shadow there.
Light light_at(const Camera& camera, double distance) {
    Light light;
    light.type = LightType::point;
    light.position = glm::vec3(camera.position);
    light.intensity = glm::vec3(float(host::pi * distance * distance));
    return light;
}

// From over the camera's left shoulder; (2, -5, 14) has length 15. Irradiance pi: white reflects a radiance of 1.
Light light_behind(const Camera& camera, const Sphere& all) {
    const CameraAxes a = axes(camera);
    Light light;
    light.type = LightType::directional;
    light.direction = glm::vec3(a.right * (2 / 15.0) - a.up * (5 / 15.0) + a.forward * (14 / 15.0));
    light.position = glm::vec3(all.centre - glm::dvec3(light.direction) * (2 * all.radius));
    light.intensity = glm::vec3(float(host::pi));
    return light;
}

}  // namespace

void choose_camera(Scene& scene, const Geometry& geometry) {
    const Sphere all = sphere_around(geometry);
    const bool reversed_z = scene.camera.reversed_z;
    scene.camera = {};
    scene.camera.reversed_z = reversed_z;

    // From the front, the right and above; the sphere fills the height of the frame. (2, 1.5, 6) has length 6.5.
    const double distance = 1.05 * all.radius / host::sin(scene.camera.fov_y_deg * (host::pi / 360));
    scene.camera.look_at = all.centre;
    scene.camera.position = all.centre + glm::dvec3(2, 1.5, 6) * (distance / 6.5);
    scene.camera.near = std::max(distance - 1.1 * all.radius, 0.001 * distance);
    scene.camera.far = distance + 1.1 * all.radius;
    scene.notes.push_back(fmt::format("no camera in the file: one at ({:.4g}, {:.4g}, {:.4g}) m that sees everything",
                                      scene.camera.position.x, scene.camera.position.y, scene.camera.position.z));
}

void choose_light(Scene& scene, const Geometry& geometry) {
    const Sphere all = sphere_around(geometry);
    const std::vector<double> seen = Look(scene.camera, scene.frame_size).distances(geometry);
    if (seen.empty()) scene.notes.push_back("the camera sees no surface, or next to none");
    Light light;
    if (inside(scene.camera.position, geometry)) {
        const double distance = seen.empty() ? all.radius / 2 : seen[seen.size() / 2];
        light = light_at(scene.camera, distance);
        scene.notes.push_back(fmt::format(
            "no light in the file: the camera stands within the scene, so a point light of {:.3g} W/sr stands there, too: "
            "irradiance 3.14 W/m2 at {:.3g} m, half of what is seen is nearer",
            light.intensity.x, distance));
    } else {
        light = light_behind(scene.camera, all);
        scene.notes.push_back(
            "no light in the file: a directional one from behind the camera, its upper left, irradiance 3.14 W/m2");
    }
    light.name = "key";
    scene.lights.push_back(light);
}

}  // namespace plumb::io
