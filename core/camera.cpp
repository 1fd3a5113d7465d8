#include "core/camera.h"

#include <fmt/format.h>

#include <cmath>

#include "core/host_math.h"

namespace plumb {
namespace {

double length(const glm::dvec3& v) { return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z); }

// Scales by the largest component first, so that no square overflows or vanishes.
glm::dvec3 normalised(const glm::dvec3& v) {
    const glm::dvec3 scaled = v / std::fmax(std::fmax(std::fabs(v.x), std::fabs(v.y)), std::fabs(v.z));
    return scaled / length(scaled);
}

bool finite(const glm::dvec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

double tan_half_fov(const Camera& camera) { return host::tan(camera.fov_y_deg * (host::pi / 360)); }

// Clip depth as a function of eye depth d: perspective (slope d + offset) / d, orthographic slope d + offset.
struct DepthMap {
    double slope, offset;
};
DepthMap perspective_depth(const Camera& camera) {
    const double n = camera.near, f = camera.far;
    if (std::isinf(f)) return camera.reversed_z ? DepthMap{0, n} : DepthMap{1, -n};
    const double slope = f / (f - n);
    return camera.reversed_z ? DepthMap{-n / (f - n), n * slope} : DepthMap{slope, -n * slope};
}

// Columns of the projection from canonical view space; flips what the convention sees the other way round.
glm::dmat4 assemble(double x_scale, double y_scale, DepthMap depth, bool perspective, Convention convention) {
    const ConventionRules& r = rules(convention);
    const double towards = r.view_left_handed ? 1 : -1;  // eye depth is `towards` times view z
    glm::dmat4 m(0);
    m[0][0] = x_scale;
    m[1][1] = r.clip_y_up ? y_scale : -y_scale;
    m[2][2] = towards * depth.slope, m[3][2] = depth.offset;
    if (perspective)
        m[2][3] = towards;
    else
        m[3][3] = 1;

    // Depth -1..1 is 2 z - w.
    if (r.depth_from_minus_1)
        for (int column = 2; column < 4; ++column) m[column][2] = 2 * m[column][2] - m[column][3];
    return m;
}

void require(bool holds, const std::string& field, const std::string& value, const std::string& allowed) {
    if (!holds) throw InputError("camera: " + field + " = " + value + ": must be " + allowed);
}

std::string text(const glm::dvec3& v) { return fmt::format("[{}, {}, {}]", v.x, v.y, v.z); }

}  // namespace

void validate(const Camera& camera) {
    require(finite(camera.position), "position", text(camera.position), "finite");
    require(finite(camera.look_at) && camera.look_at != camera.position, "look_at", text(camera.look_at),
            "finite and away from position");
    require(finite(camera.up) && camera.up != glm::dvec3(0), "up", text(camera.up), "finite and not zero");
    const glm::dvec3 across = glm::cross(normalised(camera.look_at - camera.position), normalised(camera.up));
    require(length(across) > 1e-6, "up", text(camera.up), "not parallel to look_at - position");
    require(camera.fov_y_deg > 0 && camera.fov_y_deg < 180, "fov_y_deg", fmt::to_string(camera.fov_y_deg),
            "above 0 and below 180 degrees");
    require(camera.near > 0 && std::isfinite(camera.near), "near", fmt::to_string(camera.near), "above 0 m and finite");
    require(camera.far > camera.near, "far", fmt::to_string(camera.far),
            fmt::format("above near = {} m, or inf", camera.near));
}

CameraAxes axes(const glm::dvec3& forward, const glm::dvec3& up) {
    const glm::dvec3 f = normalised(forward), right = normalised(glm::cross(f, normalised(up)));
    return {right, glm::cross(right, f), f};
}

CameraAxes axes(const Camera& camera) { return axes(camera.look_at - camera.position, camera.up); }

glm::dmat4 view_matrix(const glm::dvec3& eye, const CameraAxes& axes, Convention convention) {
    const glm::dvec3 z = rules(convention).view_left_handed ? axes.forward : -axes.forward;
    const glm::dvec3 rows[] = {axes.right, axes.up, z};
    glm::dmat4 m(1);
    for (int i = 0; i < 3; ++i) {
        const glm::dvec3& a = rows[i];
        m[0][i] = a.x, m[1][i] = a.y, m[2][i] = a.z;
        m[3][i] = -(a.x * eye.x + a.y * eye.y + a.z * eye.z);
    }
    return m;
}

glm::dmat4 view_matrix(const Camera& camera, Convention convention) {
    return view_matrix(camera.position, axes(camera), convention);
}

glm::dmat4 projection_matrix(const Camera& camera, double aspect, Convention convention) {
    const double y_scale = 1 / tan_half_fov(camera);
    return assemble(y_scale / aspect, y_scale, perspective_depth(camera), true, convention);
}

glm::dmat4 orthographic_matrix(const OrthographicBox& box, Convention convention) {
    const double range = box.far - box.near;
    const DepthMap depth =
        box.reversed_z ? DepthMap{-1 / range, box.far / range} : DepthMap{1 / range, -box.near / range};
    return assemble(1 / box.half_width, 1 / box.half_height, depth, false, convention);
}

View make_view(const Camera& camera, double aspect) { return make_view(camera, aspect, Convention::vulkan, {1, 1}); }

View make_view(const Camera& camera, double aspect, Convention convention, glm::ivec2 size) {
    View view;
    view.world_to_view = view_matrix(camera, convention);
    view.view_to_clip = half_pixel_shift(size, convention) * projection_matrix(camera, aspect, convention);
    view.to_canonical = to_canonical(size, convention);
    view.eye = camera.position;
    view.forward = axes(camera).forward;
    view.reversed_z = camera.reversed_z;
    view.far = camera.far;
    return view;
}

Ray ray_through(const Camera& camera, glm::ivec2 size, const glm::dvec2& window) {
    const CameraAxes a = axes(camera);
    const double top = tan_half_fov(camera), right = top * size.x / size.y;
    const double x = (2 * window.x / size.x - 1) * right, y = (1 - 2 * window.y / size.y) * top;
    return {camera.position, normalised(a.forward + a.right * x + a.up * y)};
}

Ray ray_through_pixel(const Camera& camera, glm::ivec2 size, glm::ivec2 pixel) {
    return ray_through(camera, size, glm::dvec2(pixel) + 0.5);
}

double linear_depth(const Camera& camera, const glm::dvec3& position) {
    const glm::dvec3 f = axes(camera).forward, d = position - camera.position;
    return f.x * d.x + f.y * d.y + f.z * d.z;
}

double linear_depth_from_clip(const Camera& camera, double depth) {
    // depth = slope + offset / d
    const DepthMap m = perspective_depth(camera);
    const double denominator = depth - m.slope;
    return denominator == 0 ? std::numeric_limits<double>::infinity() : m.offset / denominator;
}

}  // namespace plumb
