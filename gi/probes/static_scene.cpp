#include "gi/probes/static_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "core/error.h"

namespace plumb::probes {

Geometry flatten_static(const Scene& scene) {
    const auto dynamic = [](const Mesh& m) { return m.dynamic; };
    if (std::none_of(scene.meshes.begin(), scene.meshes.end(), dynamic)) return flatten(scene);
    Scene fixed;
    std::remove_copy_if(scene.meshes.begin(), scene.meshes.end(), std::back_inserter(fixed.meshes), dynamic);
    if (fixed.meshes.empty())
        throw InputError(fmt::format("bake: {}: every mesh is dynamic: expected one that stands still, whose light is baked",
                                     scene.name.empty() ? "scene" : scene.name));
    fixed.materials = scene.materials;  // they tell which meshes need tangents
    return flatten(fixed);
}

void drop_normal_maps(raster::Surfaces& surfaces) {
    for (std::size_t m = 0; m < surfaces.masked.size(); ++m) surfaces.materials[m * std::size_t(record_stride) + 10] = 0;
}

std::vector<std::int32_t> static_triangles(const Scene& scene, const Geometry& geometry) {
    std::vector<std::int32_t> index;
    std::int32_t count = 0;
    for (const std::int32_t object : geometry.object) index.push_back(scene.meshes[std::size_t(object)].dynamic ? -1 : count++);
    return index;
}

}  // namespace plumb::probes
