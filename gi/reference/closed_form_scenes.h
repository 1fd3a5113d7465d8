// Scenes and points of the closed forms. Shapes are flat-shaded: their light is that of the polyhedron, whatever the
// interpolation of normals.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "gi/reference/closed_forms.h"
#include "gi/reference/reference.h"
#include "raster/rsm.h"

namespace plumb::reference {

// The list as it grows.
struct ClosedFormList {
    std::vector<ClosedForm> forms;

    using Run = std::function<Measured(const ClosedFormOptions&)>;
    // What is sampled has to lie within 0.2 %.
    void add(const std::string& name, const std::string& source, const std::string& unit, double expected, Run run) {
        forms.push_back({name, source, unit, expected, 0.002, true, std::move(run)});
    }
    void add_quadrature(const std::string& name, const std::string& source, const std::string& unit, double expected,
                        double bound, Run run) {
        forms.push_back({name, source, unit, expected, bound, false, std::move(run)});
    }
};
void add_open_scenes(ClosedFormList& list);  // lamps, environment, mirror and Phong's lobe
void add_quadratures(ClosedFormList& list);  // the gather over a reflective shadow map

// From a differential area to a rectangle a x b. The normal, or the foot of the perpendicular on the rectangle's plane,
// passes through a corner. Howell, "A Catalog of Radiation Heat Transfer Configuration Factors", B-3 and B-4.
double to_parallel_rectangle(double a, double b, double distance);
double to_perpendicular_rectangle(double width, double height, double distance);

// Grey; emission M in W/m2.
Material grey(double reflectance, double emission = 0);

// Each adds a mesh of one material.
void add_quad(Scene& scene, const Material& material, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c,
              const glm::dvec3& d);
// A rectangle across an axis: from `low` to `high`, which have one component in common.
void add_rectangle(Scene& scene, const Material& material, const glm::dvec3& low, const glm::dvec3& high);
void add_cube(Scene& scene, const Material& material, const glm::dvec3& low, const glm::dvec3& high);
// A horizontal square of side `outer` around (0, y, 0) with a hole of side `inner`.
void add_frame(Scene& scene, const Material& material, double y, double outer, double inner);
// A horizontal disc around (0, y, 0): a polygon of 128 corners and the disc's area.
void add_disc(Scene& scene, const Material& material, double y, double radius);
// An icosahedron whose triangles were cut in four `levels` times, blown up to the sphere's area: 20 * 4^levels
// triangles.
void add_sphere(Scene& scene, const Material& material, const glm::dvec3& centre, double radius, int levels = 3);

double area(const Mesh& mesh, int material = -1);  // of the triangles of that material; -1: of all
// The middle of a triangle, and its normal on the side of `eye`.
struct SurfacePoint {
    glm::dvec3 position, normal;
};
SurfacePoint middle_of(const Mesh& mesh, std::size_t triangle, const glm::dvec3& eye);

// Whole rows of points for at least so many paths.
struct ReceiverPoints {
    Image4 position, normal;
    int samples = 0;  // paths a point
};
// One point again and again.
ReceiverPoints repeated(const glm::dvec3& position, const glm::dvec3& normal, std::uint64_t paths);
// Spread evenly by area over a mesh, few paths a point. Normals look to the side of `eye`.
ReceiverPoints spread(const Mesh& mesh, const glm::dvec3& eye, std::uint64_t paths);

Light point_lamp(const glm::dvec3& position, double power);

// The mean over points of what the path tracer finds there, of one channel. A pilot run tells how many paths it
// takes; its own result counts only where it has no error at all.
using PointMaker = std::function<ReceiverPoints(std::uint64_t paths)>;
Measured trace_points(const Scene& scene, Mode mode, const PointMaker& points, const ClosedFormOptions& options,
                      int channel = 0);

// The mean over a small frame of the radiance that a camera sees.
Measured trace_frame(const Scene& scene, const Camera& camera, const ClosedFormOptions& options);

// The mean over points of rsm.all from the maps that the rasterizer draws for the scene's first light.
Measured gather_points(const Scene& scene, const ReceiverPoints& points, const ClosedFormOptions& options);
// The same from maps that are there; rsm.all_rays where something may occlude.
struct Occluders {
    const Scene* scene = nullptr;
    float max_rays = 0;  // 0: every texel; else a subset with its standard error
};
Measured gather_maps(const std::vector<raster::Rsm>& maps, const ReceiverPoints& points,
                     const ClosedFormOptions& options, const Occluders& occluders = {});

}  // namespace plumb::reference
