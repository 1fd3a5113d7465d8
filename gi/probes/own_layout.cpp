#include "gi/probes/own_layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "gi/probes/overlap.h"
#include "gi/probes/own_uv.h"

namespace plumb::probes {
namespace {

// Triangles of an object, in texels; those without an area in space are left out.
struct ObjectTriangles {
    int object = 0;
    std::size_t first = 0, count = 0;  // of Geometry::triangles
    std::vector<PlaneTriangle> plane;
};

PlaneTriangle in_texels(const Atlas& a, std::size_t t) {
    PlaneTriangle p;
    for (int k = 0; k < 3; ++k) p[std::size_t(k)] = glm::dvec2(a.uv[a.geometry.triangles[t][k]]) * glm::dvec2(a.size);
    return p;
}

bool is_on_map(const OwnLayout& layout, int object) { return layout.on_map.empty() || layout.on_map[std::size_t(object)]; }

std::string mesh_name(const Scene& scene, int object) { return "mesh \"" + scene.meshes[std::size_t(object)].name + "\""; }

[[noreturn]] void refuse(const std::string& file, const std::string& cause) { throw InputError(file, "", cause); }

// Whether triangles of the first n objects overlap.
bool overlapping(const std::vector<ObjectTriangles>& objects, std::size_t n, const ObjectTriangles* also = nullptr) {
    std::vector<PlaneTriangle> all;
    for (std::size_t i = 0; i < n; ++i) all.insert(all.end(), objects[i].plane.begin(), objects[i].plane.end());
    if (also) all.insert(all.end(), also->plane.begin(), also->plane.end());
    return any_overlap(all, layout_slack_texels);
}

// The fewest objects from the first that `test` is true of; it is true of `all`, and stays true.
template <class Test>
std::size_t fewest(std::size_t all, Test test) {
    std::size_t low = 0, high = all;
    while (high - low > 1) {
        const std::size_t middle = (low + high) / 2;
        (test(middle) ? high : low) = middle;
    }
    return high;
}

void refuse_overlap(const Scene& scene, const std::vector<ObjectTriangles>& objects, const std::string& file) {
    for (const ObjectTriangles& o : objects)
        if (any_overlap(o.plane, layout_slack_texels))
            refuse(file, mesh_name(scene, o.object) + ": its coordinates overlap: several places of the surface would share texels");
    if (!overlapping(objects, objects.size())) return;
    const std::size_t second = fewest(objects.size(), [&](std::size_t n) { return overlapping(objects, n); }) - 1;
    const std::size_t first = fewest(second, [&](std::size_t n) { return overlapping(objects, n, &objects[second]); }) - 1;
    refuse(file, fmt::format("{} and {}: their coordinates overlap: --mesh NAME chooses those that are on this map",
                             mesh_name(scene, objects[first].object), mesh_name(scene, objects[second].object)));
}

void check_vertices(const Scene& scene, const Atlas& a, const ObjectTriangles& o, const std::string& file) {
    const glm::dvec2 slack = layout_slack_texels / glm::dvec2(a.size);
    for (std::size_t t = o.first; t < o.first + o.count; ++t)
        for (int k = 0; k < 3; ++k) {
            const glm::dvec2 uv(a.uv[a.geometry.triangles[t][k]]);
            for (int c = 0; c < 2; ++c)
                if (!(uv[c] >= -slack[c] && uv[c] <= 1 + slack[c]))
                    refuse(file, fmt::format("{}: a texture coordinate is ({:.6g}, {:.6g}): expected 0 to 1 in a lightmap",
                                             mesh_name(scene, o.object), uv.x, uv.y));
        }
}

// Islands need edges, and these the coordinates in the vertices: a copy has them.
Geometry with_coordinates(const Atlas& a) {
    Geometry g = a.geometry;
    for (std::size_t v = 0; v < g.vertices.size(); ++v) g.vertices[v].u = a.uv[v].x, g.vertices[v].v = a.uv[v].y;
    return g;
}

void add_charts(Atlas& a, const Geometry& coordinates, ObjectTriangles& o) {
    const SurfaceMesh mesh = surface_mesh(coordinates, o.object, o.first, o.count);
    UvIslands islands;
    find_islands(mesh, islands);
    std::vector<PlaneBox> boxes(std::size_t(islands.count), PlaneBox{glm::dvec2(HUGE_VAL), glm::dvec2(-HUGE_VAL)});
    for (std::size_t t = 0; t < o.count; ++t) {
        if (islands.of[t] < 0) {
            ++a.summary.triangles_without_area;
            continue;
        }
        const PlaneTriangle p = in_texels(a, o.first + t);
        const PlaneBox own = bounds_of(p);
        PlaneBox& box = boxes[std::size_t(islands.of[t])];
        box = {glm::min(box.low, own.low), glm::max(box.high, own.high)};
        a.chart[o.first + t] = std::int32_t(a.charts.size()) + islands.of[t];
        o.plane.push_back(p);
        a.summary.used += std::fabs(twice_area(p)) / 2;
        a.texels_per_m += mesh.area[t];
    }
    for (const PlaneBox& box : boxes) {
        const glm::ivec2 low(glm::floor(box.low)), high(glm::ceil(box.high));
        a.charts.push_back({o.object, low, glm::max(high - low, glm::ivec2(1)), true});
    }
    a.summary.mirrored_islands += islands.mirrored;
    ++a.summary.meshes_kept;
}

// Triangles of an object follow each other.
std::vector<ObjectTriangles> objects_of(const Geometry& g, const OwnLayout& layout) {
    std::vector<ObjectTriangles> objects;
    for (std::size_t t = 0; t < g.triangles.size(); ++t) {
        if (!is_on_map(layout, g.object[t])) continue;
        if (objects.empty() || objects.back().object != g.object[t]) objects.push_back({g.object[t], t, 0, {}});
        ++objects.back().count;
    }
    return objects;
}

void check_aspect(const Atlas& a, const std::string& file) {
    if (a.size.x == a.size.y) return;
    const double square = texel_aspect(a), own = square * a.size.y / a.size.x;
    if (std::max(own, 1 / own) > std::max(square, 1 / square) * (1 + 1e-9))
        refuse(file, fmt::format("is {} x {} texels, which would be {:.3g} times as wide as high on the surfaces, of a square map {:.3g}: "
                                 "expected a map of the layout's aspect",
                                 a.size.x, a.size.y, own, square));
}

}  // namespace

double texel_aspect(const Atlas& a) {
    double across = 0, down = 0;  // sums of area |dP/du|^2 and |dP/dv|^2
    for (std::size_t t = 0; t < a.chart.size(); ++t) {
        if (a.chart[t] < 0) continue;
        const glm::uvec3 c = a.geometry.triangles[t];
        const glm::dvec3 p(a.geometry.vertices[c.x].position), e = glm::dvec3(a.geometry.vertices[c.y].position) - p,
                         f = glm::dvec3(a.geometry.vertices[c.z].position) - p;
        const glm::dvec2 o(a.uv[c.x]), g = glm::dvec2(a.uv[c.y]) - o, h = glm::dvec2(a.uv[c.z]) - o;
        const double twice = g.x * h.y - g.y * h.x;
        if (twice == 0) continue;
        const glm::dvec3 du = (e * h.y - f * g.y) / twice, dv = (f * g.x - e * h.x) / twice;
        // Weighted by the area in the plane: as many texels see it.
        const double weight = std::fabs(twice);
        across += weight * std::sqrt(glm::dot(du, du)), down += weight * std::sqrt(glm::dot(dv, dv));
    }
    return down > 0 ? across / down : 1;
}

Atlas own_layout(const Scene& scene, const Geometry& geometry, const OwnLayout& layout, const std::string& file) {
    Atlas a;
    a.geometry = geometry;
    a.uv = layout.uv;
    a.size = layout.size;
    a.chart.assign(geometry.triangles.size(), -1);
    std::vector<ObjectTriangles> objects = objects_of(geometry, layout);
    if (objects.empty()) refuse(file, "no mesh of the scene is on this map");
    for (const ObjectTriangles& o : objects) check_vertices(scene, a, o, file);
    const Geometry coordinates = with_coordinates(a);
    for (ObjectTriangles& o : objects) add_charts(a, coordinates, o);
    if (!(a.summary.used > 0))
        refuse(file, mesh_name(scene, objects.front().object) + ": its texture coordinates have no area: there is no layout");
    a.texels_per_m = std::sqrt(a.summary.used / a.texels_per_m);
    a.summary.used /= double(a.size.x) * a.size.y;
    refuse_overlap(scene, objects, file);
    check_aspect(a, file);
    // What is not on the map covers none of it.
    for (std::size_t t = 0; t < a.chart.size(); ++t)
        if (!is_on_map(layout, geometry.object[t]))
            for (int k = 0; k < 3; ++k) a.uv[geometry.triangles[t][k]] = glm::vec2(0);
    return a;
}

}  // namespace plumb::probes
