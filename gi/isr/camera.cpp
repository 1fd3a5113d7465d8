#include <fmt/format.h>

#include <cmath>

#include "core/error.h"
#include "core/host_math.h"
#include "gi/isr/isr.h"

namespace plumb::isr {

namespace {

// What is seen at eye depth 1 m through window position (x, y) of a frame: right and up, m.
struct Frustum {
    double top, right;  // tan(fov_y / 2), and that times the aspect
    glm::dvec2 size;

    double across(double x) const { return (2 * x / size.x - 1) * right; }
    double above(double y) const { return (1 - 2 * y / size.y) * top; }
};
Frustum frustum_of(const Camera& camera, glm::ivec2 size) {
    const double top = host::tan(camera.fov_y_deg * (host::pi / 360));
    return {top, top * size.x / size.y, glm::dvec2(size)};
}

// The inverse of the canonical projection of a rectangle at eye depth 1 m: (left, top) to (right, bottom), m.
glm::dmat4 inverse_projection(const glm::dvec2& left_top, const glm::dvec2& right_bottom, double near, double far) {
    const glm::dvec2 half = (right_bottom - left_top) * 0.5, middle = (right_bottom + left_top) * 0.5;
    // Clip depth is slope + offset / z.
    const double slope = std::isinf(far) ? 1 : far / (far - near), offset = -near * slope;
    glm::dmat4 m(0);
    m[0][0] = half.x;
    m[1][1] = half.y;
    m[2][3] = 1 / offset;
    m[3] = {middle.x, middle.y, -1, -slope / offset};
    return m;
}

}  // namespace

CoarseCamera coarse_camera(const Camera& camera, glm::ivec2 frame_size, int guard, int side) {
    validate(camera);
    if (guard < 0 || guard % 2 != 0)
        throw InputError(fmt::format("isr: guard = {}: expected an even number, 0 or more", guard));
    const CameraAxes a = axes(camera);
    const Frustum frustum = frustum_of(camera, frame_size);
    CoarseCamera c;
    c.eye = camera.position;
    c.footprint = 2 * side * frustum.top / frame_size.y;  // pixels are 2 top / height
    c.f_u = a.right * c.footprint, c.f_v = a.up * -c.footprint;
    c.f_o = a.forward + a.right * frustum.across(side / 2.0) + a.up * frustum.above(side / 2.0);
    c.near = camera.near, c.far = camera.far;
    c.size = coarse_size(frame_size, side) + 2 * guard / side;
    c.view_to_world = glm::dmat4(glm::dvec4(a.right, 0), glm::dvec4(a.up, 0), glm::dvec4(-a.forward, 0), {0, 0, 0, 1});
    const glm::dvec2 first(-guard), last = first + double(side) * glm::dvec2(c.size);  // window positions of the corners
    c.clip_to_view = inverse_projection({frustum.across(first.x), frustum.above(first.y)},
                                        {frustum.across(last.x), frustum.above(last.y)}, c.near, c.far);
    return c;
}

FrustumVectors frustum_vectors(const Camera& camera, glm::ivec2 size, Convention convention) {
    validate(camera);
    if (std::isinf(camera.far)) throw InputError("camera: far = inf: expected a far plane, which ISR (23) scales by");
    const View view = make_view(camera, double(size.x) / size.y, convention, size);
    const ConventionRules& r = rules(convention);
    const glm::dmat4& projection = view.view_to_clip;
    const double z = projection[2][3] * camera.far;  // view space: the clip w of a point there is camera.far

    // The far plane's point that texture coordinate (u, v) shows, in the axes of the world.
    auto at = [&](double u, double v) {
        // Where that lies in the window, from the top left, by the interface's count of pixel centres; and in clip space.
        const glm::dvec2 window = glm::dvec2(u, v) * glm::dvec2(size) + (r.pixel_centre - 0.5);
        const glm::dvec2 h = 2.0 * window / glm::dvec2(size) - 1.0;
        const glm::dvec2 clip(h.x, r.clip_y_up ? -h.y : h.y);
        const glm::dvec2 in_view((clip.x * camera.far - projection[2][0] * z) / projection[0][0],
                                 (clip.y * camera.far - projection[2][1] * z) / projection[1][1]);
        return glm::dvec3(glm::transpose(view.world_to_view) * glm::dvec4(in_view, z, 0));
    };
    const glm::dvec3 corner = at(0, 0);
    return {corner, at(1, 0) - corner, at(0, 1) - corner};
}

}  // namespace plumb::isr
