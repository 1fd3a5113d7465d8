// The statements of an OBJ, before any of it is put together. Private to io/.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "io/findings.h"

namespace plumb::io {

// Indices from 0 of a position, a texture coordinate and a normal; -1: none.
struct Corner {
    std::int32_t position = -1, texture = -1, normal = -1;
    friend bool operator==(const Corner& a, const Corner& b) {
        return a.position == b.position && a.texture == b.texture && a.normal == b.normal;
    }
};

struct Face {
    std::size_t first;  // of its corners
    std::int64_t line;
    std::int32_t material;  // index into `materials`; -1: none
};

// Names, each once and with the line where it first occurs.
struct Names {
    std::vector<std::pair<std::string, std::int64_t>> list;
    std::map<std::string, std::int32_t> index;
};

// What the lines say, before any of it is put together.
struct ObjLines {
    std::vector<glm::vec3> positions, normals;
    std::vector<glm::vec2> texture_coordinates;
    std::vector<Corner> corners;
    std::vector<Face> faces;
    Names libraries, materials;  // of mtllib, of usemtl
    // What is passed over.
    std::int64_t coloured = 0, points = 0, lines = 0, surfaces = 0;  // vertices; statements
};

// Throws InputError for what is malformed; what is passed over goes to `findings`.
ObjLines scan_obj(const std::string& path, std::string_view text, Findings& findings);

}  // namespace plumb::io
