// Tangents for normal maps, compatible with MikkTSpace (Mikkelsen 2008, "Simulation of Wrinkled Surfaces Revisited"),
// which glTF 2.0 (3.7.2.1) names for meshes that bring none.
#pragma once

#include "core/scene.h"

namespace plumb {

// Fills mesh.tangents: the direction of increasing u in the plane across the vertex normal, unit, and w, which makes
// w cross(normal, tangent) point up in the image (against v). Vertices that face groups of triangles with different
// tangents share are split: new vertices go to the end, in the order of the triangles. A vertex that no triangle with
// an area in the image reaches gets (1, 0, 0, 1).
void generate_tangents(Mesh& mesh);

}  // namespace plumb
