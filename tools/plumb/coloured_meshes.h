// The elements of method radiosity as meshes with colours of vertices.
#pragma once

#include <vector>

#include "gi/frame/frame.h"
#include "io/coloured_mesh.h"

namespace plumb::cli {

// A mesh for each of the scene's. Vertices are elements; where elements are triangles, each has three vertices of its own. All light:
// irradiance with that of lamps at the element, radiosity M + rho H. Empty where the frame solved nothing.
std::vector<io::ColouredMesh> coloured_meshes(const Scene& scene, const frame::Frame& frame);

// Colours are radiosity times this: the radiance that the picture shows, under its exposure.
float mesh_scale(const frame::Settings& settings);

}  // namespace plumb::cli
