#include "raster/light_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/camera.h"
#include "core/error.h"
#include "core/host_math.h"

namespace plumb::raster {
namespace {

double dot(const glm::dvec3& a, const glm::dvec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

glm::dvec3 unit_direction(const Light& light) {
    const glm::dvec3 d(light.direction);
    const double length = std::sqrt(dot(d, d));
    if (!(length > 1e-30 && length < 1e30))
        throw InputError(fmt::format("light \"{}\": direction = [{}, {}, {}]: expected a finite vector, not zero",
                                     light.name, light.direction.x, light.direction.y, light.direction.z));
    return d / length;
}

glm::dvec3 up_for(const glm::dvec3& forward) {
    return std::abs(forward.y) > 0.999 ? glm::dvec3(0, 0, 1) : glm::dvec3(0, 1, 0);
}

View spot_view(const Light& light, const glm::dvec3& low, const glm::dvec3& high) {
    if (!(light.cone_outer_deg > 0 && light.cone_outer_deg < 90))
        throw InputError(fmt::format("light \"{}\": cone_outer_deg = {}: expected above 0 and below 90 degrees",
                                     light.name, light.cone_outer_deg));
    // Depths of the corners of the bounds.
    const glm::dvec3 eye(light.position), forward = unit_direction(light);
    double nearest = unbounded, farthest = -unbounded;
    for (int i = 0; i < 8; ++i) {
        const glm::dvec3 corner(i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z);
        const double depth = dot(forward, corner - eye);
        nearest = std::min(nearest, depth), farthest = std::max(farthest, depth);
    }

    Camera camera;
    camera.position = eye;
    camera.look_at = eye + forward;
    camera.up = up_for(forward);
    camera.fov_y_deg = 2.0 * light.cone_outer_deg;
    camera.far = farthest > 0 ? farthest * 1.001 : 1;
    camera.near = std::min(std::max(nearest * 0.999, camera.far * 1e-6), camera.far * 0.5);
    camera.reversed_z = true;
    View view = make_view(camera, 1);
    // The axes come from the direction itself: eye + forward has lost digits where the light is far from the origin.
    const CameraAxes a = axes(forward, camera.up);
    view.world_to_view = view_matrix(eye, a);
    view.forward = a.forward;
    return view;
}

View directional_view(const Light& light, const glm::dvec3& low, const glm::dvec3& high) {
    const glm::dvec3 forward = unit_direction(light), centre = (low + high) * 0.5, half = (high - low) * 0.5;
    // A margin of 1/1024 keeps what lies on the sphere off the border of the map.
    const double radius = std::max(std::sqrt(dot(half, half)), 1e-6) * (1 + 0x1p-10);
    const CameraAxes a = axes(forward, up_for(forward));
    View view;
    view.eye = centre - a.forward * radius;
    view.forward = a.forward;
    view.world_to_view = view_matrix(view.eye, a);
    view.view_to_clip = orthographic_matrix({radius, radius, 0, 2 * radius, true});
    view.orthographic = true;
    view.reversed_z = true;
    return view;
}

}  // namespace

View light_view(const Light& light, const glm::vec3& low, const glm::vec3& high) {
    switch (light.type) {
        case LightType::spot: return spot_view(light, glm::dvec3(low), glm::dvec3(high));
        case LightType::directional: return directional_view(light, glm::dvec3(low), glm::dvec3(high));
        default: break;
    }
    throw InputError(fmt::format("light \"{}\": a point light has no single view: expected a spot or directional light",
                                 light.name));
}

glm::dvec2 project_to_texels(const View& view, int size, const glm::dvec3& x) {
    const glm::dmat4 m = view.world_to_clip();
    auto row = [&](int r) { return m[0][r] * x.x + m[1][r] * x.y + m[2][r] * x.z + m[3][r]; };
    const double w = row(3);
    return {(row(0) / w + 1) * 0.5 * size, (row(1) / w + 1) * 0.5 * size};
}

LightArgs light_args(const Light& light) {
    LightArgs a{};
    const glm::dvec3 direction = light.type == LightType::point ? glm::dvec3(0, -1, 0) : unit_direction(light);
    for (int c = 0; c < 3; ++c) {
        a.position[c] = light.position[c];
        a.direction[c] = float(direction[c]);
        a.intensity[c] = light.intensity[c];
    }
    a.directional = light.type == LightType::directional ? 1.0f : 0.0f;
    a.cos_outer = -2;
    a.falloff_scale = 1e30f;
    if (light.type != LightType::spot) return a;
    const double inner = host::cos(light.cone_inner_deg * (host::pi / 180));
    const double outer = host::cos(light.cone_outer_deg * (host::pi / 180));
    a.cos_outer = float(outer);
    a.falloff_scale = inner > outer ? float(std::min(1 / (inner - outer), 1e30)) : 1e30f;
    return a;
}

}  // namespace plumb::raster
