// Form factors between flat polygons by contour integrals, where nothing stands between them: the truth that a
// hemicube's rows and rays are held against. In double precision, with the same bits everywhere.
//
//     from a point      F = 1/(2 pi) sum over edges of angle_k n . (r_k x r_k+1) / |r_k x r_k+1|            (Lambert
//     1760) from a polygon    F = 1/(2 pi A_i) sum over pairs of edges of d_p . d_q  integral ln r ds dt (Stokes)
//
// Does not know what lies between: `plumb formfactor` asks rays.
#pragma once

#include <glm/glm.hpp>
#include <string>
#include <vector>

namespace plumb::radiosity {

// Corners of a convex, flat polygon, m: counter-clockwise as seen from its front.
using Polygon = std::vector<glm::dvec3>;

// Which sides of a target count: both, as the rasterizer draws it, or its front alone, as of a closed surface.
enum class Sides : int { both, front };

glm::dvec3 area_vector(const Polygon& polygon);  // normal times area, m2
double area(const Polygon& polygon);             // m2
double area(const std::vector<Polygon>& polygons);

// Throws InputError that starts with `name`: fewer than 3 corners, not finite, no area, not flat (beyond `flatness` of
// its size) or not convex.
void check_polygon(const std::string& name, const Polygon& polygon, double flatness = 1e-6);

// The part in front of the plane through `point`, normal to `normal` (unit). Corners within `margin` of the plane lie
// on it.
Polygon clip_to_front(const Polygon& polygon, const glm::dvec3& point, const glm::dvec3& normal, double margin);

// From a differential area to a polygon, of which the part above its horizon counts; 0 where the point lies in the
// polygon's plane. normal: of any length.
double point_form_factor(const glm::dvec3& point, const glm::dvec3& normal, const Polygon& target,
                         Sides sides = Sides::both);

struct ContourFactor {
    double value = 0;
    double error = 0;  // absolute: estimate of the quadrature's and rounding's
};

// From the front of one polygon to another: to the part of it in front. Where `from` crosses the other's plane, the
// parts on both sides of it are taken one by one. Pairs of edges on parallel or crossing lines, so also those that
// touch, have closed forms; of skew ones one integral is closed, the other adaptive (Gauss and Kronrod, 15 points) up
// to `tolerance` of F.
ContourFactor polygon_form_factor(const Polygon& from, const Polygon& to, Sides sides = Sides::both,
                                  double tolerance = 1e-12);

// The same between surfaces of many polygons, none of which hides another: the mean over `from` of the sum over `to`.
ContourFactor surface_form_factor(const std::vector<Polygon>& from, const std::vector<Polygon>& to,
                                  Sides sides = Sides::both, double tolerance = 1e-12);
double point_form_factor(const glm::dvec3& point, const glm::dvec3& normal, const std::vector<Polygon>& to,
                         Sides sides = Sides::both);

}  // namespace plumb::radiosity
