#include "gi/radiosity/lamp_light.h"

#include <algorithm>
#include <cmath>

#include "gi/probes/lit_hits.h"
#include "gi/radiosity/triangle_places.h"

namespace plumb::radiosity {
namespace {

using Point = glm::dvec3;

constexpr int places_of_triangle = 16;
constexpr std::size_t triangles_at_once = 1 << 14;  // whose places lie in memory

struct Sum {
    Point light{0};
    double weight = 0;
};

// Light at places of triangles [first, last), by element.
void add_places(const probes::LitScene& lit, const Elements& e, std::size_t first, std::size_t last, const RunOptions& options, std::vector<Sum>& sums) {
    const int count = int(last - first);
    Image4 position(places_of_triangle, count), normal(places_of_triangle, count);
    std::vector<double> area(std::size_t(count), 0.0);
    for (int t = 0; t < count; ++t) {
        const glm::uvec3 v = e.geometry.triangles[first + std::size_t(t)], of = e.of[first + std::size_t(t)];
        const Point a(e.geometry.vertices[v.x].position), b(e.geometry.vertices[v.y].position), c(e.geometry.vertices[v.z].position);
        const Point face = glm::cross(b - a, c - a);
        area[std::size_t(t)] = std::sqrt(glm::dot(face, face)) / 2;
        if (!(area[std::size_t(t)] > 0)) continue;
        for (int k = 0; k < places_of_triangle; ++k) {
            const Point w = triangle_place(k);
            const Point n = w.x * Point(e.normal[of.x]) + w.y * Point(e.normal[of.y]) + w.z * Point(e.normal[of.z]);
            const double length = std::sqrt(glm::dot(n, n));
            const Point up = length > 0 ? n / length : Point(0);
            normal(k, t) = glm::vec4(glm::vec3(up), 0);
            position(k, t) = glm::vec4(glm::vec3(w.x * a + w.y * b + w.z * c + e.offset_m * up), 0);
        }
    }
    const Image4 light = probes::lamp_irradiance(lit, position, normal, options);
    for (int t = 0; t < count; ++t)
        for (int k = 0; k < places_of_triangle; ++k) {
            const Point w = triangle_place(k);
            for (int c = 0; c < 3; ++c) {
                Sum& s = sums[e.of[first + std::size_t(t)][c]];
                const double weight = area[std::size_t(t)] * w[c];
                s.light += weight * Point(light(k, t)), s.weight += weight;
            }
        }
}

}  // namespace

Buffer<glm::vec4> lamps_on(const Scene& scene, const Elements& elements, const RunOptions& options) {
    const bool dark = std::none_of(scene.lights.begin(), scene.lights.end(), [](const Light& light) { return light.on; });
    if (elements.count() == 0 || dark) return Buffer<glm::vec4>(std::size_t(elements.count()), glm::vec4(0));
    const auto lit = probes::lit_scene(scene, Rays::exact);
    std::vector<Sum> sums(std::size_t(elements.count()));
    for (std::size_t first = 0; first < elements.of.size(); first += triangles_at_once)
        add_places(*lit, elements, first, std::min(elements.of.size(), first + triangles_at_once), options, sums);
    Buffer<glm::vec4> out;
    for (const Sum& s : sums) out.push_back(glm::vec4(glm::vec3(s.weight > 0 ? s.light / s.weight : Point(0)), 0));
    return out;
}

}  // namespace plumb::radiosity
