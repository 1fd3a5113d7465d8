#include "gi/frame/mirrors.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "gi/frame/relief_use.h"

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

std::string lobes_left_out(const Scene& scene, const Settings& settings) {
    if (settings.method == Method::reference) return "";
    std::vector<char> used(scene.materials.size());
    for (const Mesh& mesh : scene.meshes)
        for (const std::int32_t m : mesh.material)
            if (m >= 0 && m < int(used.size())) used[std::size_t(m)] = 1;
    int all = 0, facets = 0, metals = 0, lobes = 0, mirrors = 0;
    for (std::size_t i = 0; i < used.size(); ++i) {
        if (!used[i]) continue;
        const Material& m = scene.materials[i];
        ++all, facets += m.microfacet, metals += m.microfacet && m.metalness > 0;
        lobes += m.specular != glm::vec3(0), mirrors += m.mirror != glm::vec3(0);
    }
    if (reflects(settings)) mirrors = 0;
    if (reflects(settings) && settings.reflect.lobe == screen::Lobe::phong) lobes = 0;
    if (settings.method == Method::zbuffer || relief_use(scene, settings).highlights) lobes = 0;
    std::vector<std::string> parts;
    if (facets > 0) parts.push_back(fmt::format("microfacets of {}{}", facets, metals > 0 ? fmt::format(" (metal of {}, shown as diffuse)", metals) : ""));
    if (lobes > 0) parts.push_back(fmt::format("Phong's lobe of {}", lobes));
    if (mirrors > 0) parts.push_back(fmt::format("the mirror of {}", mirrors));
    if (parts.empty()) return "";
    return fmt::format("method {} leaves out, of {} material{}: {}; --method reference shows them", method_name(settings.method), all,
                       all == 1 ? "" : "s", fmt::join(parts, ", "));
}

}  // namespace plumb::frame
