// Spheres that stand for dynamic meshes where these hide indirect light (indirect_shadow_kernel.h). Host only: a mesh is fitted once,
// in its own space; where it stands, and what arrives there, is a few numbers a sphere.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "core/scene.h"
#include "core/stage.h"
#include "gi/probes/spatial.h"

namespace plumb::probes {

// At most `count` of them, of the triangles that are drawn; xyz m, w radius m, in the mesh's own space. None of a mesh without
// area. Points inside of it (between the 1st and 2nd, 3rd and 4th ... surface along lines of a grid; what is left over counts as
// a point itself) are parted by k-means; a sphere has the volume of its part, then all radii are scaled so that the spheres' discs
// add up to the mesh's mean projected area: of a mesh far away no more and no less is hidden. The same bits everywhere. Throws
// InputError for a mesh that is not finite.
Buffer<glm::vec4> fit_spheres(const Mesh& mesh, int count);

// The mean area that the mesh covers, seen from 32 directions over the hemisphere; m2, in its own space.
double projected_area(const Mesh& mesh);

// Of a scene's dynamic meshes, as probes.indirect_shadow reads them; at least one, of radius 0 where nothing moves.
struct ShadowSpheres {
    Buffer<glm::vec4> rows;            // [sphere][7]
    std::vector<std::int32_t> owner;   // [sphere] index into Scene::meshes; -1: none

    int count() const { return int(owner.size()); }
};
// fitted: fit_spheres() of each mesh of the scene, empty of static ones. A transform that is not rigid scales radii by the root of the
// mean square of its columns' lengths. The light is 0.
ShadowSpheres place_spheres(const Scene& scene, const std::vector<Buffer<glm::vec4>>& fitted);

// Radiance a + b . w of each sphere's surroundings, by irradiance of six directions at its centre, of the grid:
//
//     a = sum_axes (E_+ + E_-) / (6 pi), b_axis = 3 (E_+ - E_-) / (4 pi)              exact for radiance of degree 0 and 1
//
// and, where the object reflects rho, what a sphere of it sends: a' = rho a, b' = -4/9 rho b. reflects: as Scene::meshes; black where it
// is empty.
void light_spheres(const SpatialGrid& grid, const Buffer<glm::vec4>& irradiance, const std::vector<glm::vec3>& reflects,
                   const RunOptions& options, ShadowSpheres& spheres);

// Of each mesh: the mean reflectance of its triangles' materials, by area in its own space; textures are not looked up.
std::vector<glm::vec3> mean_reflectance(const Scene& scene);

StageInfo info_shadow_spheres();

}  // namespace plumb::probes
