// Divides surfaces where others stand on them, so that no light is interpolated through what stands there.
//
// Where the edge of a box lies on a floor's triangle, the triangle is cut along it, and the edge where it meets edges of the floor:
// both then have the same corners there, and elements.h makes two elements of each, one before the box and one below it. A corner
// that lies inside of another triangle's edge (a T-junction) divides that edge.
#pragma once

#include <cstdint>

#include "core/scene.h"

namespace plumb::radiosity {

struct Cut {
    Scene scene;
    std::int64_t corners = 0;      // put into edges where another corner was
    std::int64_t crossings = 0;    // where two edges cross
    std::int64_t inside = 0;       // corners put into triangles
    int rounds = 0;                // in each a triangle gets a corner at most, and so does an edge
};

// Meshes come back as tessellate() makes them. Edges between triangles of one plane are not cut along, and not at corners of what lies
// on them: a floor and a sheet on it stay as they are, and so do bodies that run into each other without an edge there.
// What is nearer than meeting_distance() meets; no edge is cut nearer to its end than 128 of it, and no triangle lower than that, a
// quarter of a millimetre in a room of 2 m: at corners that are rounded by less, cuts would have no end. Throws InputError where there are
// more triangles than asked.
Cut cut_contacts(const Scene& scene, std::int64_t most_triangles = 4'000'000);

}  // namespace plumb::radiosity
