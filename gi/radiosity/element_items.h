// What hemicubes of elements see, texel by texel: radiosity.items run for a few at a time, for what reads more of them than rows keep.
#pragma once

#include <cstdint>
#include <vector>

#include "core/image.h"
#include "core/isa.h"
#include "gi/radiosity/elements.h"

namespace plumb::radiosity {

struct SeenItems {
    std::vector<std::int32_t> triangle;  // [3 size count][size]; -1: none
    Image4 at;                           // barycentrics of corners 1 and 2, 1/depth; 1: a front, -1: a back, 0: nothing
};

class ElementItems {
  public:
    ElementItems(const Elements& elements, int size);
    // Of elements [first, first + count).
    SeenItems seen(int first, int count, const RunOptions& options) const;
    int size() const { return size_; }
    // Where a texel of element i looks: world space, of any length. row: of the hemicube.
    glm::dvec3 direction(int i, int row, int column) const;

  private:
    int size_;
    Buffer<glm::vec4> vertices_, eyes_;
    Buffer<glm::ivec4> triangles_;
};

// 0 the top, then the sides u, -u, t, -t.
int face_of_row(int size, int row);

}  // namespace plumb::radiosity
