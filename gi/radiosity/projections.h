// The alternatives to a hemicube (HEM 4.5.3): one picture from an element in place of five. To compare; rows are made of hemicubes.
//
//     plane       the picture of a plane, its angle of view nearly pi; each texel weighs its integral, as a hemicube's top
//     fish_eye    the same picture, then resampled as a lens sees it: the nearest texel for each of a disc's, which all
//                 weigh the same (orthographic: r = sin theta, Nusselt's analogue)
//
// Both lose what lies outside of the picture: all that is lower than its edge.
#pragma once

#include <vector>

#include "core/isa.h"
#include "core/scene.h"
#include "gi/radiosity/ray_form_factors.h"
#include "raster/surfaces.h"

namespace plumb::radiosity {

enum class Projection : int { plane, fish_eye };

struct ProjectionParams {
    Projection projection = Projection::plane;
    int size = 110;        // texels across of what is drawn, and of the lens' disc; even, 2 to 4096
    double view_deg = 170; // across, from side to side: above 0, below 180
    bool rescale = false;  // to a sum of 1: what is lost counts as if it were like the rest
};

// The share of a diffuse receiver's irradiance that comes through the picture.
double share_of_view(double view_deg);

// Of the drawn texels, row by row, the first the uppermost. Throws InputError for parameters out of range.
std::vector<double> projection_weights(const ProjectionParams& params);

// As hemicube_form_factor() (hemicube_factor.h) has it.
double projected_form_factor(const Geometry& geometry, const raster::Surfaces* surfaces, const std::vector<SourcePoint>& points,
                             const std::vector<std::int32_t>& targets, const ProjectionParams& params, double offset,
                             const RunOptions& options);

// Texels across of one picture with about as many texels as a hemicube of that size has, 3 size^2: an even number.
int size_of_equal_texels(int hemicube);

}  // namespace plumb::radiosity
