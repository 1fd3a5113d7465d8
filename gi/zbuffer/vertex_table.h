// The vertices that the z-buffer techniques shade: what vertex buffers of a GPU would hold.
#pragma once

#include <vector>

#include "core/scene.h"

namespace plumb::zbuffer {

// A vertex that triangles of several materials share is there once for each; one without a normal once for each of its corners,
// with the triangle's. Only what triangles use is there.
struct VertexTable {
    Buffer<glm::vec4> vertices;       // [vertex][2]: xyz m; xyz unit normal, or 0 of a triangle without area
    std::vector<glm::ivec2> kinds;    // [vertex]: index into Scene::materials, into Scene::meshes
    std::vector<glm::ivec4> corners;  // [triangle of the frame]: its three vertices; 0
    Buffer<glm::vec4> materials;      // [material][2]: reflectance; specular, exponent
    Buffer<glm::vec4> objects;        // [mesh][6]: rows of M M^T and of M, M the linear part of its transform; each over its largest
                                      // element
};
// geometry: flatten(scene). Throws InputError for a material that does not exist.
VertexTable vertex_table(const Scene& scene, const Geometry& geometry);

}  // namespace plumb::zbuffer
