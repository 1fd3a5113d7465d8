#include "io/choose_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

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
    Light light;
    light.name = "key";
    light.type = LightType::directional;
    // From above, the left and the front; (2, -6, -3) has length 7. Irradiance pi: white reflects a radiance of 1.
    light.direction = glm::vec3(2.0f / 7, -6.0f / 7, -3.0f / 7);
    light.position = glm::vec3(all.centre - glm::dvec3(light.direction) * (2 * all.radius));
    light.intensity = glm::vec3(float(host::pi));
    scene.lights.push_back(light);
    scene.notes.push_back("no light in the file: a directional one from the upper left, irradiance 3.14 W/m2");
}

}  // namespace plumb::io
