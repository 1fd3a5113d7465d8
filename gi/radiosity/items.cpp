#include "gi/radiosity/items.h"

#include <fmt/format.h>

#include <cmath>

#include "core/error.h"
#include "gi/lend.h"
#include "raster/hemicube.h"

namespace plumb::radiosity {

Buffer<glm::vec4> eyes_of(const Buffer<glm::vec4>& position, const Buffer<glm::vec4>& normal) {
    Buffer<glm::vec4> eyes;
    eyes.reserve(4 * position.size());
    for (std::size_t i = 0; i < position.size(); ++i) {
        const glm::dvec3 n(normal[i]);
        raster::HemicubeAxes axes{};
        const double largest = std::fmax(std::fmax(std::fabs(n.x), std::fabs(n.y)), std::fabs(n.z));
        if (largest > 0 && std::isfinite(n.x) && std::isfinite(n.y) && std::isfinite(n.z)) axes = raster::hemicube_axes(n);
        for (const glm::dvec3& v : {glm::dvec3(position[i]), axes.u, axes.t, axes.n}) eyes.push_back(glm::vec4(glm::vec3(v), 0));
    }
    return eyes;
}

StageData data_of(const ItemsInputs& in, int first, int count) {
    const char* stage = "radiosity.items";
    if (!in.vertices || !in.triangles || !in.eyes || in.vertices->empty() || in.triangles->empty() || in.eyes->empty())
        throw InputError(fmt::format("{}: vertices, triangles and eyes must be bound", stage));
    if (in.size < 2 || in.size > largest_hemicube || in.size % 2 != 0)
        throw InputError(fmt::format("{}: size = {}: expected an even number of 2 to {} texels", stage, in.size, largest_hemicube));
    const int hemicubes = int(in.eyes->size() / 4), rows = rows_of_hemicube(in.size);
    if (first < 0 || count < 1 || first > hemicubes - count || std::int64_t(count) * rows > rows_a_dispatch)
        throw InputError(fmt::format("{}: hemicubes {} to {} of {}: expected at most {} at once", stage, first, std::int64_t(first) + count,
                                     hemicubes, rows_a_dispatch / rows));
    const float texel = 2.0f / float(in.size);
    const int vertices = int(in.vertices->size()), triangles = int(in.triangles->size());
    StageData d = begin_data<ItemsKernel>({in.size, count * rows},
                                          ItemsUniforms{in.size, count * rows, vertices, triangles, texel, texel / 64, {}});
    lend(d.inputs, "eyes", {4 * std::int64_t(count), 4}, &(*in.eyes)[4 * std::size_t(first)].x);
    lend(d.inputs, "vertices", {vertices, 4}, &(*in.vertices)[0].x);
    lend(d.inputs, "triangles", {triangles, 4}, &(*in.triangles)[0].x);
    return d;
}

}  // namespace plumb::radiosity
