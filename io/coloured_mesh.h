// A mesh whose vertices have a radiosity, as a file that any viewer opens: GLB or OBJ.
//
// GLB: COLOR_0 (VEC3 float, linear) is radiosity times the scale, at most 1, on a material of KHR_materials_unlit; beside it the
// attributes _RADIOSITY and _IRRADIANCE (VEC3 float, W/m2). OBJ: `v x y z r g b`, r g b the radiosity times the scale, linear, without
// a limit. The scale stands in both: asset.extras.plumb.colour_scale, a comment. Floats are written in full: they come back to the bit.
#pragma once

#include <glm/glm.hpp>
#include <string>
#include <vector>

namespace plumb::io {

struct ColouredMesh {
    std::string name;
    std::vector<glm::vec3> position, normal;       // m, world; unit
    std::vector<glm::vec3> radiosity, irradiance;  // W/m2
    std::vector<glm::uvec3> triangles;
};

// By the file's extension, .glb or .obj; throws InputError for others, and for what is not finite. What was at the path stays until
// the file is complete.
void write_coloured(const std::string& path, const std::vector<ColouredMesh>& meshes, float scale);
// The same error for a name alone, before there is a mesh.
void require_coloured_name(const std::string& path);

}  // namespace plumb::io
