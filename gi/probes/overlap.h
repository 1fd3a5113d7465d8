// Whether triangles of a plane overlap: what decides if texture coordinates can serve a lightmap (IPR 3.2.1.1: "no mesh
// UV coordinates collide"), and if a projected chart folds over itself.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace plumb::probes {

using PlaneTriangle = std::array<glm::dvec2, 3>;

// Twice the signed area: positive where the corners turn from x towards y.
double twice_area(const PlaneTriangle& t);

// Whether a side of one triangle leaves the other one outside, but for `tolerance` in the plane's unit. Triangles that
// share a side or a corner, and lie beside each other, do not overlap. Both need an area; either may be mirrored.
bool overlap(const PlaneTriangle& a, const PlaneTriangle& b, double tolerance);

// Whether any two overlap. Exact but for the tolerance, by halving the plane until few triangles share a box;
// triangles without area are left out. Where more than 2^24 + 64 n pairs would have to be tested, the answer is true
// without a proof: a lightmap that leaves them apart is always right.
bool any_overlap(const std::vector<PlaneTriangle>& triangles, double tolerance);

struct PlaneBox {
    glm::dvec2 low, high;
};
PlaneBox bounds_of(const PlaneTriangle& t);
// Whether the triangle may reach into the box: never a wrong no.
bool reaches(const PlaneTriangle& t, const PlaneBox& box);

}  // namespace plumb::probes
