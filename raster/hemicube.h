// The pass hemicube: which triangle each pixel of the five faces of a hemicube sees (HEM 4.5.3, 5.6; Cohen and
// Greenberg 1985, "The Hemi-Cube"). See raster/README.md.
//
//            top: size x size, seen along n                   a side: size x size/2, seen along its axis
//
//                 up u                                                up n
//             +----------+                                     +----------+   z = 1: the top's edge
//             |     n    |  right                              |          |
//             |    (.)   |  u x n ... t                        +----------+   z = 0: the surface's own plane
//             +----------+
#pragma once

#include <vector>

#include "core/image.h"
#include "core/isa.h"
#include "core/scene.h"
#include "core/stage.h"
#include "core/view.h"
#include "raster/surfaces.h"
#include "raster/visibility.h"

namespace plumb::raster {

inline constexpr int hemicube_faces = 5;  // n, u, -u, t, -t (HEM table 5.1)

// n is normalised; u = o x n / |o x n| with o = (1, 0, 0), or (0, 1, 0) where |n.x| > 0.9; t = u x n (HEM (5.8)-(5.10)).
// differs: (5.8) asks whether n is about (+-1, 0, 0) without a bound; 0.9 is ours, and u is normalised.
struct HemicubeAxes {
    glm::dvec3 n, u, t;
};
HemicubeAxes hemicube_axes(const glm::dvec3& normal);

// What each face sees from `eye`: 90 degrees for the top, the upper half of 90 degrees for a side. Depth is reversed and
// has no far end. Throws InputError where the normal has no length or near is not above 0 m.
std::vector<View> hemicube_views(const glm::dvec3& eye, const glm::dvec3& normal, double near);

struct Hemicube {
    int size = 0;
    VisibilityBuffer faces[hemicube_faces];
};

// size: pixels across, even, 2 to 4096. `surfaces` may be null: then no material has holes. Reuses `out`.
void draw_hemicube(const Geometry& geometry, const Surfaces* surfaces, const glm::dvec3& eye, const glm::dvec3& normal,
                   double near, int size, const RunOptions& options, Hemicube& out, Workspace* workspace = nullptr);

// The share of a diffuse receiver's irradiance that comes through each pixel, row by row, at pixel centres: of the top
// dA / (pi (x^2 + y^2 + 1)^2), of a side z dA / (pi (y^2 + z^2 + 1)^2), with dA = (2 / size)^2 (HEM 4.5.3, corrected:
// the multiplier maps (5.5) and (5.7) are not normalised and have a cosine where its cube is due). The top and four
// sides add up to 1.
std::vector<double> delta_form_factors_top(int size);
std::vector<double> delta_form_factors_side(int size);

StageInfo info_hemicube();

}  // namespace plumb::raster
