// Flat mirrors, in which a path sees the images of lamps.
#pragma once

#include <string>
#include <vector>

#include "core/image.h"
#include "core/scene.h"

namespace plumb::reference {

struct MirrorTable {
    Buffer<float> planes;                // [plane][4]: unit normal n and d, n . x = d, m
    Buffer<std::int32_t> plane;          // [triangle]: of a flat mirror its plane, else -1; empty where there is none
    int count = 0;                       // planes
    bool curved = false;                 // some mirror's normals are not its triangles': lamps have no image in it
};

// Triangles whose material mirrors and whose shading normals are those of their plane, gathered by plane. Those whose planes
// differ by rounding alone may get several: an image is found in each all the same.
MirrorTable mirror_table(const Scene& scene, const Geometry& geometry);

// What light of the scene's lamps paths do not find, in words; empty where they find all.
std::vector<std::string> lamp_light_unseen(const Scene& scene, const Geometry& geometry);

}  // namespace plumb::reference
