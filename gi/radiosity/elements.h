// The elements of radiosity (HEM 4.5.4): points at which irradiance is computed, and how what leaves them varies between.
//
//     vertices     one at each corner of the mesh, split where the surface is: at creases, between materials, between
//                  objects; radiosity is linear over a triangle ("per-vertex", 5.5)
//     triangles    one in the middle of each triangle; radiosity is constant on it ("per-triangle", 6.4)
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "core/image.h"
#include "core/isa.h"
#include "core/scene.h"

namespace plumb::radiosity {

enum class Kind : int { vertices, triangles };

struct ElementParams {
    Kind kind = Kind::vertices;
    double crease_deg = 30;   // triangles whose normals differ by more are no one surface, 0..180
    double offset = 1e-4;     // of the scene's diagonal: how far off the surface an element looks from, and how far in from its
                              // patch's border
    bool inset = true;        // off: as HEM 5.6 has it, along the normal alone
    bool split = true;        // off: published: one element a position, its normal the mean of all around it
    bool of_file = false;     // HEM 5.5: one element a vertex of the file, with the normal that it has there; crease_deg and
                              // split do not count
    double small_emitters = 0;  // of the scene's area: what emits, and has no more, is taken for lamps (emitters.h)
};

struct Elements {
    Kind kind = Kind::vertices;
    Geometry geometry;                       // of all meshes, world space
    std::vector<glm::uvec3> of;              // [triangle]: element at each corner; of triangles three times the same
    Buffer<glm::vec4> position, normal;      // m, on the surface; unit, outwards
    Buffer<glm::vec4> eye;                   // m: where its hemicube stands; w: how far off the surface, m
    Buffer<glm::vec4> reflectance;           // 0..1, xyz
    Buffer<glm::vec4> exitance;              // W/m2, what it emits, as texels see it
    Buffer<glm::vec4> lamp_exitance;         // what it emits and texels do not see: lamps' light; empty where there is none
    std::vector<double> area;                // m2: integral of what interpolates it
    double offset_m = 0;                     // at least 2^-18 of the largest coordinate: what rounding leaves of positions
    std::int64_t nearer = 0;                 // elements off whose surface geometry is nearer than twice the offset: they
                                             // look from half way to it
    std::int64_t without_normal = 0;         // whose triangles have no area: they see nothing
    std::int64_t inset = 0;                  // moved in from their patch's border
    int count() const { return int(position.size()); }
};

// Elements look out of the front of triangles alone: what lies behind a sheet, it does not receive. Throws InputError for
// parameters out of range, a scene without triangles and positions that are not finite.
//
// differs: HEM 5.6 moves by one unit along the normal that the file gives a vertex, whatever the scene's size, and a vertex of
// two walls is one. Ours is split where the surface is, and moved in from its patch's border as well: at a wall's foot it
// would stand in the plane of the wall, and see past it.
Elements elements_of(const Scene& scene, const ElementParams& params, const RunOptions& options = {});

}  // namespace plumb::radiosity
