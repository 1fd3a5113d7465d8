#include "tools/plumb/formfactor_shapes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>

#include "core/error.h"
#include "core/nearest_known.h"
#include "io/file.h"

namespace plumb::cli {
namespace {

using radiosity::Polygon;

std::string trimmed(const std::string& text) {
    const std::size_t first = text.find_first_not_of(" ("), last = text.find_last_not_of(" )");
    return first == std::string::npos || last < first ? "" : text.substr(first, last - first + 1);
}

std::vector<std::string> parts_of(const std::string& text, char between) {
    std::vector<std::string> parts;
    std::size_t start = 0;
    for (std::size_t end; (end = text.find(between, start)) != std::string::npos; start = end + 1)
        parts.push_back(text.substr(start, end - start));
    parts.push_back(text.substr(start));
    return parts;
}

glm::dvec3 parse_point(const std::string& name, const std::string& text) {
    const std::vector<std::string> words = parts_of(text, ',');
    glm::dvec3 point(0);
    bool whole = words.size() == 3;
    for (int k = 0; whole && k < 3; ++k) {
        const std::string word = trimmed(words[std::size_t(k)]);
        const auto [end, fault] = std::from_chars(word.data(), word.data() + word.size(), point[k]);
        whole = fault == std::errc() && end == word.data() + word.size() && std::fabs(point[k]) <= 1e18;
    }
    if (!whole)
        throw InputError(fmt::format("{}: {}: expected x,y,z, each a number up to 1e18", name, io::printable(text)));
    return point;
}

// Adds a mesh without a name; the polygon's corners are what floats keep of them.
void add_mesh(Scene& scene, Polygon& polygon) {
    Mesh mesh;
    const glm::dvec3 along = radiosity::area_vector(polygon);
    for (glm::dvec3& corner : polygon) {
        Vertex v;
        v.position = glm::vec3(corner), v.normal = glm::vec3(along / glm::length(along));
        mesh.vertices.push_back(v);
        corner = glm::dvec3(v.position);
    }
    for (std::uint32_t i = 2; i < polygon.size(); ++i) mesh.triangles.push_back({0, i - 1, i});
    mesh.material.assign(mesh.triangles.size(), std::int32_t(scene.materials.size()) - 1);
    scene.meshes.push_back(mesh);
}

// Every edge stands once in each direction.
bool is_closed(const std::vector<Polygon>& faces) {
    using Edge = std::array<double, 6>;
    std::map<Edge, int> edges;
    for (const Polygon& f : faces)
        for (std::size_t i = 0; i < f.size(); ++i) {
            const glm::dvec3 p = f[i], q = f[(i + 1) % f.size()];
            ++edges[{p.x, p.y, p.z, q.x, q.y, q.z}];
        }
    for (const auto& [e, count] : edges) {
        const auto opposite = edges.find(Edge{e[3], e[4], e[5], e[0], e[1], e[2]});
        if (count != 1 || opposite == edges.end() || opposite->second != 1) return false;
    }
    return true;
}

std::string in_quotes(const std::string& text) { return "\"" + io::printable(text) + "\""; }

// Triangles that the words name, counted without the meshes that were put before them.
std::vector<std::uint32_t> named(const std::string& name, std::string text, const Scene& scene, const Geometry& g,
                                 std::uint32_t first, std::string& words) {
    std::vector<std::uint32_t> found;
    const std::uint32_t count = std::uint32_t(g.triangles.size()) - first;
    if (!text.empty() && text.find_first_not_of("0123456789") == std::string::npos) {
        std::uint32_t index = 0;
        const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), index);
        if (fault != std::errc() || index >= count)
            throw InputError(
                fmt::format("{}: triangle {}: the scene has {}, counted from 0", name, io::printable(text), count));
        words = "triangle " + text;
        return {first + index};
    }
    const bool object = text.rfind("object:", 0) == 0, material = text.rfind("material:", 0) == 0;
    if (object || material) text = text.substr(text.find(':') + 1);
    std::vector<std::string> names;
    auto has = [&](const auto& list) {
        bool any = false;
        for (const auto& part : list) names.push_back(part.name), any = any || part.name == text;
        return any;
    };
    const bool is_object = !material && has(scene.meshes), is_material = !object && has(scene.materials);
    std::erase(names, std::string());
    if (!is_object && !is_material)
        throw InputError(fmt::format("{}: no {} {}{}", name,
                                     object     ? "object"
                                     : material ? "material"
                                                : "object or material",
                                     in_quotes(text), io::shown(nearest_known(text, names, "\"\""))));
    if (is_object && is_material)
        throw InputError(fmt::format("{}: an object and a material are named {}: write object:{} or material:{}", name,
                                     in_quotes(text), io::printable(text), io::printable(text)));
    for (std::uint32_t t = first; t < g.triangles.size(); ++t) {
        const std::string& of =
            is_object ? scene.meshes[std::size_t(g.object[t])].name : scene.materials[std::size_t(g.material[t])].name;
        if (of == text) found.push_back(t);
    }
    words = (is_object ? "object " : "material ") + in_quotes(text);
    return found;
}

Polygon face_of(const Geometry& g, std::uint32_t t) {
    Polygon face;
    for (int k = 0; k < 3; ++k) face.push_back(glm::dvec3(g.vertices[g.triangles[t][k]].position));
    return face;
}

struct Reading {
    std::string name, text;
    Shape* shape;
    bool given = false;  // as coordinates
    Polygon polygon;
};

void read_coordinates(Reading& r, bool may_be_point) {
    r.text = trimmed(r.text);
    if (r.text.empty()) throw InputError(r.name + ": empty: expected a name, a triangle's number or coordinates");
    if (r.text.find(';') == std::string::npos && r.text.find('/') == std::string::npos) return;
    if (r.text.find(',') == std::string::npos) return;  // a name may have a slash
    r.given = true;
    if (r.text.find(';') == std::string::npos) {
        const std::vector<std::string> words = parts_of(r.text, '/');
        if (!may_be_point) throw InputError(r.name + ": a point: only A may be one");
        if (words.size() != 2)
            throw InputError(fmt::format("{}: {}: expected a point as x,y,z/nx,ny,nz", r.name, io::printable(r.text)));
        r.shape->source.point = parse_point(r.name, words[0]), r.shape->source.normal = parse_point(r.name, words[1]);
        const double length = glm::length(r.shape->source.normal);
        if (!(length > 0)) throw InputError(r.name + ": the normal has no length");
        r.shape->source.normal /= length;
        r.shape->words = "point";
        return;
    }
    for (const std::string& corner : parts_of(r.text, ';')) r.polygon.push_back(parse_point(r.name, corner));
    radiosity::check_polygon(r.name, r.polygon);
    r.shape->words = fmt::format("polygon of {} corners", r.polygon.size());
}

}  // namespace

ShapePair find_shapes(const std::string& a, const std::string& b, const Scene* scene) {
    ShapePair pair;
    Reading readings[2] = {{"A", a, &pair.a, false, {}}, {"B", b, &pair.b, false, {}}};
    for (Reading& r : readings) read_coordinates(r, &r == readings);
    for (const Reading& r : readings)
        if (!r.given && !scene)
            throw InputError(fmt::format("{}: {} is no coordinates: --scene says of which scene it is a part", r.name,
                                         in_quotes(r.text)));
    if (scene) pair.scene = *scene;
    std::vector<Mesh> own;
    std::swap(own, pair.scene.meshes);
    pair.scene.materials.push_back(Material{});
    for (Reading& r : readings)
        if (!r.polygon.empty()) {
            add_mesh(pair.scene, r.polygon);
            radiosity::check_polygon(r.name, r.polygon);
        }
    const std::size_t given = pair.scene.meshes.size();
    pair.scene.meshes.insert(pair.scene.meshes.end(), own.begin(), own.end());
    pair.geometry = flatten(pair.scene);
    const Geometry& g = pair.geometry;
    std::uint32_t first = 0;
    while (first < g.triangles.size() && std::size_t(g.object[first]) < given) ++first;
    std::uint32_t next = 0;
    std::vector<bool> taken(g.triangles.size(), false);
    for (Reading& r : readings) {
        Shape& shape = *r.shape;
        if (r.polygon.empty() && r.given) continue;
        if (r.given) {
            for (std::size_t k = 2; k < r.polygon.size(); ++k) shape.triangles.push_back(next++);
            shape.source.faces = {r.polygon};
        } else {
            shape.triangles = named(r.name, r.text, pair.scene, g, first, shape.words);
        }
        for (const std::uint32_t t : shape.triangles) {
            if (taken[t]) throw InputError(fmt::format("A and B share triangle {} of the scene", t - first));
            taken[t] = true;
            const Polygon face = face_of(g, t);
            if (!r.given && radiosity::area(face) > 0) shape.source.faces.push_back(face);
        }
        if (shape.source.faces.empty())
            throw InputError(fmt::format("{}: {} has no triangle with an area", r.name, shape.words));
        shape.closed = shape.source.faces.size() > 3 && is_closed(shape.source.faces);
    }
    return pair;
}

}  // namespace plumb::cli
