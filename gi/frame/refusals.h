// What a frame cannot serve, said before it is rendered. See README.md, "Refused in advance".
#pragma once

#include <string>
#include <vector>

#include "gi/frame/frame.h"

namespace plumb::frame {

// plan() calls both; they throw InputError that names the light, the material, the mesh or the extent at fault.

// Before anything is planned:
//   floats    vertices that are not finite, scenes whose squared distances leave the range of a float, and scenes that
//             are smaller than what their distance from the origin leaves of a float
//   paths     a closed room that the camera is in whose walls reflect everything: the series of reflections diverges
void refuse_scene(const Scene& scene, const Settings& settings, const Geometry& geometry);

// Of the stages that the plan runs: positions, depths, fluxes and emission that overflow their targets, and fluxes that
// all vanish in theirs. Of every plan: a layout that asks what the camera has not.
void refuse_plan(const Scene& scene, const Settings& settings, const Geometry& geometry, const Plan& plan);

// What will be rendered, but may not be what is wanted; one sentence each.
std::vector<std::string> warnings(const Scene& scene, const Settings& settings);

// A bound on the spectral radius of reflection: the largest reflectance, all parts and channels, of the materials that
// the geometry uses. The rows of the form factors' matrix add up to at most one.
double spectral_radius_bound(const Scene& scene, const Geometry& geometry);

// The least number of passes after which what is left out of sum rho^k is at most `error` of it: rho^n <= error. For
// 0 < rho < 1 and 0 < error < 1.
double passes_needed(double rho, double error);

}  // namespace plumb::frame
