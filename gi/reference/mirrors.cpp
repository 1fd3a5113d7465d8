#include "gi/reference/mirrors.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "gi/reference/mirror_kernel.h"

namespace plumb::reference {
namespace {

// Normals of vertices are rounded; what leans by more bends what it mirrors.
constexpr double largest_lean = 1e-5;  // |sin|

}  // namespace

MirrorTable mirror_table(const Scene& scene, const Geometry& geometry) {
    MirrorTable table;
    const auto mirrors = [&](std::int32_t m) { return scene.materials[std::size_t(m)].mirror != glm::vec3(0); };
    if (std::none_of(geometry.material.begin(), geometry.material.end(), mirrors)) return table;

    table.plane.assign(geometry.triangles.size(), -1);
    std::map<std::array<float, 4>, std::int32_t> known;
    for (std::size_t t = 0; t < geometry.triangles.size(); ++t) {
        const std::int32_t material = geometry.material[t];
        if (!mirrors(material)) continue;
        const glm::uvec3 corners = geometry.triangles[t];
        const glm::dvec3 a(geometry.vertices[corners.x].position);
        glm::dvec3 n = glm::cross(glm::dvec3(geometry.vertices[corners.y].position) - a,
                                  glm::dvec3(geometry.vertices[corners.z].position) - a);
        const double length = std::sqrt(glm::dot(n, n));
        if (!(length > 0)) continue;  // no ray meets it
        n = n / length;
        bool flat = scene.materials[std::size_t(material)].normal_texture < 0;
        for (int k = 0; k < 3; ++k) {
            const glm::dvec3 lean = glm::cross(glm::dvec3(geometry.vertices[corners[k]].normal), n);
            flat = flat && glm::dot(lean, lean) <= largest_lean * largest_lean;
        }
        table.curved = table.curved || !flat;
        if (!flat) continue;
        // Both sides mirror: one of the two normals stands for both.
        if (n.x < 0 || (n.x == 0 && (n.y < 0 || (n.y == 0 && n.z < 0)))) n = -n;
        const std::array<float, 4> plane = {float(n.x), float(n.y), float(n.z), float(glm::dot(n, a))};
        const auto [at, is_new] = known.try_emplace(plane, std::int32_t(known.size()));
        if (is_new) table.planes.insert(table.planes.end(), plane.begin(), plane.end());
        table.plane[t] = at->second;
    }
    table.count = int(known.size());
    return table;
}

std::vector<std::string> lamp_light_unseen(const Scene& scene, const Geometry& geometry) {
    std::vector<std::string> unseen;
    const auto shines = [](const Light& l) { return l.on && l.intensity != glm::vec3(0); };
    if (std::none_of(scene.lights.begin(), scene.lights.end(), shines)) return unseen;
    const MirrorTable table = mirror_table(scene, geometry);
    if (table.curved) unseen.push_back("light of lamps by way of mirrors that are curved or have a normal map");
    if (table.count > 1) unseen.push_back(fmt::format("light of lamps by way of more than {} mirrors", longest_mirror_chain));
    return unseen;
}

}  // namespace plumb::reference
