#include "raster/light_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

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

void check_radius(const Light& light) {
    const std::string what = fmt::format("light \"{}\": radius = {}", light.name, light.radius);
    if (!(light.radius == 0 || (light.radius >= least_light_radius && light.radius <= largest_light_radius)))
        throw InputError(fmt::format("{}: expected {} to {} m, or 0: the light ends nowhere", what, least_light_radius,
                                     largest_light_radius));
    if (light.radius > 0 && light.type == LightType::directional)
        throw InputError(what + ": a directional light has no distance to end at: expected 0");
}

glm::dvec3 up_for(const glm::dvec3& forward) {
    return std::abs(forward.y) > 0.999 ? glm::dvec3(0, 0, 1) : glm::dvec3(0, 1, 0);
}

glm::dvec3 corner_of(const glm::dvec3& low, const glm::dvec3& high, int i) {
    return {i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z};
}

// A square pyramid of that full angle from the light.
View perspective_view(const glm::dvec3& eye, const glm::dvec3& forward, const glm::dvec3& up, double angle_deg,
                      const glm::dvec3& low, const glm::dvec3& high) {
    // Depths of the corners of the bounds.
    double nearest = unbounded, farthest = -unbounded;
    for (int i = 0; i < 8; ++i) {
        const double depth = dot(forward, corner_of(low, high, i) - eye);
        nearest = std::min(nearest, depth), farthest = std::max(farthest, depth);
    }

    Camera camera;
    camera.position = eye;
    camera.look_at = eye + forward;
    camera.up = up;
    camera.fov_y_deg = angle_deg;
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

View spot_view(const Light& light, const glm::dvec3& low, const glm::dvec3& high) {
    if (!(light.cone_outer_deg > 0 && light.cone_outer_deg < 90))
        throw InputError(fmt::format("light \"{}\": cone_outer_deg = {}: expected above 0 and below 90 degrees",
                                     light.name, light.cone_outer_deg));
    const glm::dvec3 forward = unit_direction(light);
    return perspective_view(glm::dvec3(light.position), forward, up_for(forward), 2.0 * light.cone_outer_deg, low, high);
}

// Face +x -x +y -y +z -z of a point light.
View face_view(const Light& light, int face, const glm::dvec3& low, const glm::dvec3& high) {
    const double sign = face % 2 == 0 ? 1 : -1;
    glm::dvec3 forward(0), up(0, 1, 0);
    forward[face / 2] = sign;
    if (face / 2 == 1) up = {0, 0, -sign};
    View view = perspective_view(glm::dvec3(light.position), forward, up, 90, low, high);
    // The tangent of 45 degrees is 1: neighbours then meet without a gap.
    view.view_to_clip[0][0] = 1;
    view.view_to_clip[1][1] = view.view_to_clip[1][1] < 0 ? -1 : 1;
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

std::vector<View> light_views(const Light& light, const glm::vec3& low, const glm::vec3& high) {
    if (light.type != LightType::point) return {light_view(light, low, high)};
    std::vector<View> views;
    for (int face = 0; face < light_faces; ++face)
        views.push_back(face_view(light, face, glm::dvec3(low), glm::dvec3(high)));
    return views;
}

bool may_see(const View& view, const glm::vec3& low, const glm::vec3& high) {
    // Every corner beyond the same side of the pyramid, or behind its tip.
    const glm::dmat4 clip = view.world_to_clip();
    int outside = 0x1f;
    for (int i = 0; i < 8; ++i) {
        const glm::dvec4 c = clip * glm::dvec4(corner_of(glm::dvec3(low), glm::dvec3(high), i), 1);
        outside &= (c.x > c.w) | (c.x < -c.w) << 1 | (c.y > c.w) << 2 | (c.y < -c.w) << 3 | (c.w < 0) << 4;
    }
    return outside == 0;
}

glm::dvec2 project_to_texels(const View& view, int size, const glm::dvec3& x) {
    const glm::dmat4 m = view.world_to_clip();
    auto row = [&](int r) { return m[0][r] * x.x + m[1][r] * x.y + m[2][r] * x.z + m[3][r]; };
    const double w = row(3);
    return {(row(0) / w + 1) * 0.5 * size, (row(1) / w + 1) * 0.5 * size};
}

Projection projection_args(const View& view, int size, bool clamped) {
    Projection map{};
    const glm::dmat4 clip = view.world_to_clip();
    for (int c = 0; c < 4; ++c) {
        // texel = (clip / w * 1/2 + 1/2) * size, so its row is (clip row + w row) * size / 2
        map.to_texel_x[c] = float((clip[c][0] + clip[c][3]) * (0.5 * size));
        map.to_texel_y[c] = float((clip[c][1] + clip[c][3]) * (0.5 * size));
        map.to_texel_w[c] = float(clip[c][3]);
    }
    map.least_w = 1e-6f;
    map.low = clamped ? 0.0f : -1048576.0f;
    map.high = clamped ? float(size) - 0.5f : 1048576.0f;
    map.size = size;
    return map;
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
    check_radius(light);
    a.radius2 = light.radius * light.radius;
    a.inverse_radius2 = light.radius > 0 ? float(1 / (double(light.radius) * double(light.radius))) : 0;
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
