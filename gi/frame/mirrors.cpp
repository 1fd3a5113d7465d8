#include "gi/frame/mirrors.h"

#include <algorithm>

namespace plumb::frame {

bool any_mirror(const Scene& scene) {
    return std::any_of(scene.materials.begin(), scene.materials.end(),
                       [](const Material& m) { return m.mirror != glm::vec3(0); });
}

bool any_lobe(const Scene& scene) {
    return std::any_of(scene.materials.begin(), scene.materials.end(),
                       [](const Material& m) { return m.specular != glm::vec3(0); });
}

namespace {

// texel(material) of each triangle in `id`, 0 of none.
template <class Texel>
Image4 of_materials(const Scene& scene, const Geometry& geometry, const Image<glm::ivec2>& id, Texel texel) {
    Image4 made(id.width, id.height);
    for (std::size_t i = 0; i < made.size(); ++i) {
        const std::int32_t triangle = id.texels[i].y;
        if (triangle >= 0) made.texels[i] = texel(scene.materials[std::size_t(geometry.material[std::size_t(triangle)])]);
    }
    return made;
}

}  // namespace

Image4 mirrors_of(const Scene& scene, const Geometry& geometry, const Image<glm::ivec2>& id) {
    return of_materials(scene, geometry, id,
                        [](const Material& m) { return glm::vec4(m.mirror, m.mirror != glm::vec3(0) ? 1 : 0); });
}

Image4 lobes_of(const Scene& scene, const Geometry& geometry, const Image<glm::ivec2>& id) {
    return of_materials(scene, geometry, id, [](const Material& m) {
        return m.specular != glm::vec3(0) ? glm::vec4(m.specular, m.exponent) : glm::vec4(0);
    });
}

}  // namespace plumb::frame
