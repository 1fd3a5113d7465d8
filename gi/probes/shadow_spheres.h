// Spheres that stand for dynamic meshes where these hide indirect light (indirect_shadow_kernel.h). Host only: a mesh is fitted once,
// in its own space; where it stands, and what arrives there, is a few numbers a sphere.
#pragma once

#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "core/scene.h"
#include "core/stage.h"
#include "gi/probes/spatial.h"

namespace plumb::probes {

// Meshes that stand for one thing: neighbours in Scene::meshes, dynamic, with the same transform, such as the parts of one file.
struct MovingGroup {
    int first = 0, last = 0;  // indices of meshes
};
std::vector<MovingGroup> moving_groups(const Scene& scene);

// At most `count` of a group's triangles that are drawn; xyz m, w radius m, in its own space. None of a group without area. Points inside
// of its meshes (between the 1st and 2nd, 3rd and 4th ... surface along lines of a grid; what is left over counts as a point itself) are
// parted by k-means; a sphere has the volume of its part, then all radii are scaled so that the spheres' discs add up to the group's mean
// projected area: of a thing far away no more and no less is hidden. The same bits everywhere. Throws InputError for a mesh that is not
// finite.
Buffer<glm::vec4> fit_spheres(std::span<const Mesh> meshes, int count);

// The mean area that the meshes cover together, seen from 32 directions over the hemisphere; m2, in their own space.
double projected_area(std::span<const Mesh> meshes);

// Of a scene's dynamic meshes, as probes.indirect_shadow reads them; at least one, of radius 0 where nothing moves.
struct ShadowSpheres {
    Buffer<glm::vec4> rows;         // [sphere][7]
    std::vector<glm::ivec2> owner;  // [sphere] first and last mesh of its group; -1, -2: none

    int count() const { return int(owner.size()); }
};
// fitted: fit_spheres() of each group. A transform that is not rigid scales radii by the root of the mean square of its columns' lengths.
// The light is 0.
ShadowSpheres place_spheres(const Scene& scene, const std::vector<MovingGroup>& groups, const std::vector<Buffer<glm::vec4>>& fitted);

// Radiance a + b . w of each sphere's surroundings, by irradiance of six directions at its centre, of the grid:
//
//     a = sum_axes (E_+ + E_-) / (6 pi), b_axis = 3 (E_+ - E_-) / (4 pi)              exact for radiance of degree 0 and 1
//
// and, where a group reflects rho, what a sphere of it sends: a' = rho a, b' = -4/9 rho b. reflects: of each mesh, the first of a group
// counts; black where it is empty.
void light_spheres(const SpatialGrid& grid, const Buffer<glm::vec4>& irradiance, const std::vector<glm::vec3>& reflects,
                   const RunOptions& options, ShadowSpheres& spheres);

// Of each mesh: the mean reflectance of its group's triangles' materials, by area; textures are not looked up. 0 of static ones.
std::vector<glm::vec3> mean_reflectance(const Scene& scene);

StageInfo info_shadow_spheres();

}  // namespace plumb::probes
