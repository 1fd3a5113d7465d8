#include "gi/radiosity/element_items.h"

#include "gi/lend.h"
#include "gi/radiosity/items.h"

namespace plumb::radiosity {

int face_of_row(int size, int row) { return row < size ? 0 : 1 + (row - size) / (size / 2); }

ElementItems::ElementItems(const Elements& e, int size) : size_(size), eyes_(eyes_of(e.eye, e.normal)) {
    for (const Vertex& v : e.geometry.vertices) vertices_.push_back(glm::vec4(v.position, 0));
    for (const glm::uvec3& t : e.geometry.triangles) triangles_.push_back(glm::ivec4(glm::ivec3(t), 0));
}

SeenItems ElementItems::seen(int first, int count, const RunOptions& options) const {
    const StageData data = data_of(ItemsInputs{&vertices_, &triangles_, &eyes_, size_}, first, count);
    SeenItems out{std::vector<std::int32_t>(std::size_t(data.size.x) * std::size_t(data.size.y)), Image4(data.size.x, data.size.y)};
    Bundle outputs;
    lend(outputs, "triangle", {std::int64_t(out.triangle.size()), 1}, out.triangle.data());
    lend(outputs, "seen", {std::int64_t(out.triangle.size()), 4}, &out.at.texels[0].x);
    stage<ItemsKernel>().bind(data)->run(options, {}, outputs);
    return out;
}

// The faces' axes right, up and forward of items_kernel.h, the other way round.
glm::dvec3 ElementItems::direction(int i, int row, int column) const {
    const int face = face_of_row(size_, row), first = face == 0 ? 0 : size_ + (face - 1) * (size_ / 2);
    const double x = (column + 0.5) * 2 / size_ - 1, y = 1 - (row - first + 0.5) * 2 / size_;
    const glm::dvec3 local[5] = {{y, -x, 1}, {1, x, y}, {-1, -x, y}, {-x, 1, y}, {x, -1, y}};
    const glm::vec4* axes = &eyes_[4 * std::size_t(i)];
    const glm::dvec3& p = local[face];
    return p.x * glm::dvec3(axes[1]) + p.y * glm::dvec3(axes[2]) + p.z * glm::dvec3(axes[3]);
}

}  // namespace plumb::radiosity
