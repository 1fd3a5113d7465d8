#include "raster/hemicube.h"

#include <fmt/format.h>

#include <cmath>

#include "core/camera.h"
#include "core/error.h"
#include "core/host_math.h"
#include "raster/bindings.h"

namespace plumb::raster {
namespace {

glm::dvec3 cross(const glm::dvec3& a, const glm::dvec3& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
double dot(const glm::dvec3& a, const glm::dvec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
glm::dvec3 unit(const glm::dvec3& v) { return v / std::sqrt(dot(v, v)); }

View face_view(const glm::dvec3& eye, const glm::dvec3& forward, const glm::dvec3& up, double near, bool upper_half) {
    View view;
    view.eye = eye;
    view.forward = forward;
    view.reversed_z = true;
    view.world_to_view = view_matrix(eye, CameraAxes{cross(forward, up), up, forward});
    // w = -z, depth = near / w. The whole face has y / w from 1 (top) to -1; its upper half from 1 to 0.
    glm::dmat4 m(0);
    m[0][0] = 1;
    m[1][1] = upper_half ? -2 : -1;
    m[2][1] = upper_half ? -1 : 0;
    m[3][2] = near;
    m[2][3] = -1;
    view.view_to_clip = m;
    return view;
}

}  // namespace

HemicubeAxes hemicube_axes(const glm::dvec3& normal) {
    const double largest = std::fmax(std::fmax(std::fabs(normal.x), std::fabs(normal.y)), std::fabs(normal.z));
    if (!(largest > 0 && largest < unbounded))
        throw InputError(fmt::format("hemicube: normal = [{}, {}, {}]: expected a finite vector, not zero", normal.x,
                                     normal.y, normal.z));
    const glm::dvec3 n = unit(normal / largest);
    const glm::dvec3 o = std::fabs(n.x) > 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
    const glm::dvec3 u = unit(cross(o, n));
    return {n, u, cross(u, n)};
}

std::vector<View> hemicube_views(const glm::dvec3& eye, const glm::dvec3& normal, double near) {
    if (!(near > 0 && near < unbounded))
        throw InputError(fmt::format("hemicube: near = {}: must be above 0 m and finite", near));
    const auto [n, u, t] = hemicube_axes(normal);
    return {face_view(eye, n, u, near, false), face_view(eye, u, n, near, true), face_view(eye, -u, n, near, true),
            face_view(eye, t, n, near, true), face_view(eye, -t, n, near, true)};
}

void draw_hemicube(const Geometry& geometry, const Surfaces* surfaces, const glm::dvec3& eye, const glm::dvec3& normal,
                   double near, int size, const RunOptions& options, Hemicube& out, Workspace* workspace) {
    if (size < 2 || size > 4096 || size % 2 != 0)
        throw InputError(fmt::format("hemicube: size = {}: must be even, 2 to 4096 pixels", size));
    const std::vector<View> views = hemicube_views(eye, normal, near);
    out.size = size;
    for (int face = 0; face < hemicube_faces; ++face)
        draw_visibility(geometry, surfaces, views[std::size_t(face)], {size, face == 0 ? size : size / 2}, options,
                        out.faces[face], workspace);
}

std::vector<double> delta_form_factors_top(int size) {
    const double side = 2.0 / size;
    std::vector<double> factors;
    for (int j = 0; j < size; ++j)
        for (int i = 0; i < size; ++i) {
            const double x = (i + 0.5) * side - 1, y = (j + 0.5) * side - 1, r2 = x * x + y * y + 1;
            factors.push_back(side * side / (host::pi * r2 * r2));
        }
    return factors;
}

std::vector<double> delta_form_factors_side(int size) {
    const double side = 2.0 / size;
    std::vector<double> factors;
    for (int j = 0; j < size / 2; ++j)
        for (int i = 0; i < size; ++i) {
            const double y = (i + 0.5) * side - 1, z = 1 - (j + 0.5) * side, r2 = y * y + z * z + 1;
            factors.push_back(z * side * side / (host::pi * r2 * r2));
        }
    return factors;
}

StageInfo info_hemicube() {
    StageInfo s;
    s.name = "hemicube";
    s.source = "HEM 4.5.3, 5.6; five draws for its caller, so bound to no data of its own: a draw binds the gbuffer's "
               "triangles and a face's clip_positions";
    s.inputs = surface_ports();
    s.outputs = {
        {"top", "image r32i", "", "triangle that each pixel of the top face sees; -1 where nothing is"},
        {"sides", "image r32i", "", "[4] upper halves of the side faces u, -u, t, -t; the same"},
    };
    s.twin = "raster/item.frag";
    return s;
}

}  // namespace plumb::raster
