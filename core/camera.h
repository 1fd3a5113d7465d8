// The camera and the matrices that view and project, in double precision and without the C library.
//
// Matrices act on column vectors: clip = projection * view * world. Depth d is linear eye depth in metres, the distance
// along the view direction; clip depth is its image in [0, 1].
#pragma once

#include <glm/glm.hpp>
#include <limits>

#include "core/convention.h"
#include "core/view.h"

namespace plumb {

struct Camera {
    glm::dvec3 position{0, 0, 5};  // m, world
    glm::dvec3 look_at{0, 0, 0};   // m, world
    glm::dvec3 up{0, 1, 0};        // any length, not parallel to the view direction
    double fov_y_deg = 45;         // full angle from the bottom to the top of the frame
    double near = 0.1, far = 100;  // m; far may be infinite
    bool reversed_z = false;       // depth 1 at near, 0 at far
};

// Throws InputError that names the field, its value and what is allowed.
void validate(const Camera& camera);

// Orthonormal axes of the camera in world space.
struct CameraAxes {
    glm::dvec3 right, up, forward;
};
CameraAxes axes(const Camera& camera);
CameraAxes axes(const glm::dvec3& forward, const glm::dvec3& up);

// World to view space: the viewer at the origin, x right, y up, looking along -z (+z where the convention says so).
glm::dmat4 view_matrix(const Camera& camera, Convention convention = Convention::vulkan);
glm::dmat4 view_matrix(const glm::dvec3& eye, const CameraAxes& axes, Convention convention = Convention::vulkan);

// View to clip space. aspect = width / height.
glm::dmat4 projection_matrix(const Camera& camera, double aspect, Convention convention = Convention::vulkan);

// For directional lights: a box of 2 half_width x 2 half_height metres, from near to far (finite) along the view.
struct OrthographicBox {
    double half_width = 1, half_height = 1, near = 0, far = 1;  // m
    bool reversed_z = false;
};
glm::dmat4 orthographic_matrix(const OrthographicBox& box, Convention convention = Convention::vulkan);

// All of it at once: canonical, or with the matrices that a program of `convention` would upload for a frame of `size`
// pixels (which only Direct3D 9 needs, for its half-pixel shift). Every convention sees the same picture.
View make_view(const Camera& camera, double aspect);
View make_view(const Camera& camera, double aspect, Convention convention, glm::ivec2 size);

struct Ray {
    glm::dvec3 origin, direction;  // direction is unit
};
// The ray through a window position of a frame of `size` pixels, x right and y down from the top left corner.
Ray ray_through(const Camera& camera, glm::ivec2 size, const glm::dvec2& window);
Ray ray_through_pixel(const Camera& camera, glm::ivec2 size, glm::ivec2 pixel);

// Metres from the camera along its view direction; negative behind it.
double linear_depth(const Camera& camera, const glm::dvec3& position);
// The same from clip depth 0..1 (the inverse of the projection); infinity where the far plane is infinite.
double linear_depth_from_clip(const Camera& camera, double depth);

}  // namespace plumb
