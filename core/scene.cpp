#include "core/scene.h"

#include <algorithm>
#include <cstring>

#include "core/parallel.h"

namespace plumb {
namespace {

constexpr std::size_t block = 1 << 14;  // vertices or triangles a task

// Where a mesh's vertices and triangles begin in the geometry.
struct Place {
    std::size_t vertex = 0, triangle = 0;
};

std::size_t drawn_triangles(const Mesh& mesh) {
    return std::min(std::size_t(mesh.share * double(mesh.triangles.size())), mesh.triangles.size());
}

bool shows_normal_map(const Scene& scene, const Mesh& mesh) {
    if (mesh.tangents.empty()) return false;
    return std::any_of(mesh.material.begin(), mesh.material.end(), [&](std::int32_t m) {
        return m >= 0 && std::size_t(m) < scene.materials.size() && scene.materials[std::size_t(m)].normal_texture >= 0;
    });
}

// Calls body(first, last) for blocks of [0, count), in parallel.
template <class Body>
void for_blocks(std::size_t count, const Body& body) {
    const int blocks = int((count + block - 1) / block);
    if (blocks <= 1) return body(std::size_t(0), count);
    parallel_bands(blocks, 1, 0, [&](int first, int last) {
        body(std::size_t(first) * block, std::min(count, std::size_t(last) * block));
    });
}

struct Transform {
    glm::dmat4 matrix;
    glm::dmat3 linear, for_normals;
    bool identity, mirrored;  // mirrored: triangles turn around, and with them the side of the bitangent

    explicit Transform(const glm::dmat4& m)
        : matrix(m), linear(m), for_normals(glm::transpose(glm::inverse(linear))), identity(m == glm::dmat4(1)),
          mirrored(glm::determinant(linear) < 0) {}

    static glm::vec3 unit(const glm::dvec3& v, const glm::vec3& otherwise) {
        const double length = __builtin_sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
        return length > 0 ? glm::vec3(v / length) : otherwise;
    }
    Vertex operator()(const Vertex& v) const {
        const glm::vec3 position(matrix * glm::dvec4(glm::dvec3(v.position), 1));
        return {position, v.u, unit(for_normals * glm::dvec3(v.normal), v.normal), v.v};
    }
    // A tangent lies in the surface: it moves as positions do.
    glm::vec4 operator()(const glm::vec4& t) const {
        return glm::vec4(unit(linear * glm::dvec3(t), glm::vec3(t)), mirrored ? -t.w : t.w);
    }
};

template <class T>
void transform_all(const Transform& transform, const std::vector<T>& from, T* to) {
    for_blocks(from.size(), [&](std::size_t first, std::size_t last) {
        if (transform.identity && first < last) std::memcpy(to + first, &from[first], sizeof(T) * (last - first));
        if (transform.identity) return;
        for (std::size_t i = first; i < last; ++i) to[i] = transform(from[i]);
    });
}

void place_triangles(const Mesh& mesh, std::int32_t object, bool mirrored, const Place& place, Geometry& g) {
    const glm::uvec3 base(std::uint32_t(place.vertex));
    for_blocks(drawn_triangles(mesh), [&](std::size_t first, std::size_t last) {
        for (std::size_t t = first; t < last; ++t) {
            glm::uvec3 triangle = mesh.triangles[t] + base;
            if (mirrored) std::swap(triangle.y, triangle.z);
            g.triangles[place.triangle + t] = triangle;
            g.material[place.triangle + t] = mesh.material[t];
            g.object[place.triangle + t] = object;
        }
    });
}

}  // namespace

Geometry flatten(const Scene& scene) {
    // Size everything at once: a mesh then fills its own part.
    std::vector<Place> places;
    Place end;
    bool tangents = false;
    for (const Mesh& mesh : scene.meshes) {
        places.push_back(end);
        end.vertex += mesh.vertices.size(), end.triangle += drawn_triangles(mesh);
        tangents = tangents || shows_normal_map(scene, mesh);
    }
    Geometry g;
    g.vertices.resize(end.vertex);
    if (tangents) g.tangents.resize(end.vertex, glm::vec4(0));
    g.triangles.resize(end.triangle), g.material.resize(end.triangle), g.object.resize(end.triangle);

    for (std::size_t object = 0; object < scene.meshes.size(); ++object) {
        const Mesh& mesh = scene.meshes[object];
        const Place& place = places[object];
        const Transform transform(mesh.transform);
        transform_all(transform, mesh.vertices, g.vertices.data() + place.vertex);
        if (tangents && mesh.tangents.size() == mesh.vertices.size())
            transform_all(transform, mesh.tangents, g.tangents.data() + place.vertex);
        place_triangles(mesh, std::int32_t(object), transform.mirrored, place, g);
    }
    return g;
}

bool bounds(const Geometry& g, glm::vec3& low, glm::vec3& high) {
    if (g.triangles.empty()) return false;
    low = high = g.vertices[g.triangles[0].x].position;
    for (const glm::uvec3& t : g.triangles)
        for (std::uint32_t i : {t.x, t.y, t.z}) {
            const glm::vec3 p = g.vertices[i].position;
            for (int c = 0; c < 3; ++c) low[c] = std::min(low[c], p[c]), high[c] = std::max(high[c], p[c]);
        }
    return true;
}

}  // namespace plumb
