#include "gi/frame/mirrors.h"

#include <algorithm>

namespace plumb::frame {

bool any_mirror(const Scene& scene) {
    return std::any_of(scene.materials.begin(), scene.materials.end(),
                       [](const Material& m) { return m.mirror != glm::vec3(0); });
}

Image4 mirrors_of(const Scene& scene, const Geometry& geometry, const Image<glm::ivec2>& id) {
    Image4 mirrors(id.width, id.height);
    for (std::size_t i = 0; i < mirrors.size(); ++i) {
        const std::int32_t triangle = id.texels[i].y;
        if (triangle < 0) continue;
        const Material& m = scene.materials[std::size_t(geometry.material[std::size_t(triangle)])];
        mirrors.texels[i] = glm::vec4(m.mirror, m.mirror != glm::vec3(0) ? 1 : 0);
    }
    return mirrors;
}

}  // namespace plumb::frame
