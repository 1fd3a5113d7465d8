#include "gi/radiosity/triangle_split.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/error.h"

namespace plumb::radiosity {
namespace {

using probes::next_half_edge;
using probes::SurfaceMesh;

constexpr std::uint32_t none = 0xffffffff;
constexpr double longest_half = 0.8;           // of an edge
constexpr std::uint32_t farthest_back = 16;  // half edges among which one with the same two vertices is looked for

double squared_distance(const glm::vec3& a, const glm::vec3& b) {
    const glm::dvec3 d = glm::dvec3(a) - glm::dvec3(b);
    return glm::dot(d, d);
}

// The same for (a, b) and (b, a).
glm::vec3 middle_of(const glm::vec3& a, const glm::vec3& b) { return glm::vec3((glm::dvec3(a) + glm::dvec3(b)) * 0.5); }

// The direction of a sum; `other` where it cancels out.
glm::vec3 unit_or(const glm::dvec3& sum, const glm::vec3& other) {
    const double length = std::sqrt(glm::dot(sum, sum));
    return length > 1e-6 ? glm::vec3(sum / length) : other;
}
glm::vec3 unit_middle(const glm::vec3& a, const glm::vec3& b) { return unit_or(glm::dvec3(a) + glm::dvec3(b), a); }

}  // namespace

void require_at_most(std::size_t triangles, std::int64_t most) {
    if (std::int64_t(triangles) > most)
        throw InputError(fmt::format("radiosity: {} triangles after splitting: expected at most {}", triangles, most));
}

TriangleSplit::TriangleSplit(const Scene& scene) : geometry_(flatten(scene)), origin_(geometry_.triangles.size()) {
    for (std::size_t m = 0; m < scene.meshes.size(); ++m)
        object_.insert(object_.end(), scene.meshes[m].vertices.size(), std::int32_t(m));
    std::iota(origin_.begin(), origin_.end(), 0u);
}

SurfaceMesh TriangleSplit::edges() const {
    return probes::surface_mesh(geometry_, 0, 0, geometry_.triangles.size(), true);
}

bool TriangleSplit::can_split(const SurfaceMesh& m, std::uint32_t edge) {
    const std::uint32_t h = m.half_edges[m.edge_begin[edge]];
    const glm::vec3 a = m.corner(h).position, b = m.corner(next_half_edge(h)).position, middle = middle_of(a, b);
    const double longest = std::max(squared_distance(a, middle), squared_distance(b, middle));
    return longest < longest_half * longest_half * squared_distance(a, b);
}

double TriangleSplit::squared_length(const SurfaceMesh& m, std::uint32_t edge) {
    const std::uint32_t h = m.half_edges[m.edge_begin[edge]];
    return squared_distance(m.corner(h).position, m.corner(next_half_edge(h)).position);
}

std::size_t TriangleSplit::count_after(const SurfaceMesh& m, const std::vector<char>& marked) const {
    std::size_t count = geometry_.triangles.size();
    for (std::size_t e = 0; e < marked.size(); ++e)
        if (marked[e]) count += m.edge_begin[e + 1] - m.edge_begin[e];
    return count;
}

std::uint32_t TriangleSplit::middle(std::uint32_t a, std::uint32_t b) {
    if (a > b) std::swap(a, b);
    Geometry& g = geometry_;
    const Vertex p = g.vertices[a], q = g.vertices[b];
    g.vertices.push_back({middle_of(p.position, q.position), float((double(p.u) + double(q.u)) * 0.5),
                          unit_middle(p.normal, q.normal), float((double(p.v) + double(q.v)) * 0.5)});
    if (!g.tangents.empty()) {
        const glm::vec4 t = g.tangents[a], s = g.tangents[b];
        g.tangents.push_back(glm::vec4(unit_middle(glm::vec3(t), glm::vec3(s)), t.w));
    }
    object_.push_back(object_[a]);
    return std::uint32_t(g.vertices.size() - 1);
}

std::uint32_t TriangleSplit::mean(const glm::uvec3& of, const glm::dvec3& weights, const glm::vec3& p) {
    Geometry& g = geometry_;
    glm::dvec2 uv(0);
    glm::dvec3 normal(0), tangent(0);
    for (int k = 0; k < 3; ++k) {
        const Vertex& v = g.vertices[of[k]];
        uv += weights[k] * glm::dvec2(v.u, v.v), normal += weights[k] * glm::dvec3(v.normal);
        if (!g.tangents.empty()) tangent += weights[k] * glm::dvec3(g.tangents[of[k]]);
    }
    g.vertices.push_back({p, float(uv.x), unit_or(normal, g.vertices[of[0]].normal), float(uv.y)});
    if (!g.tangents.empty()) {
        const glm::vec4 first = g.tangents[of[0]];
        g.tangents.push_back(glm::vec4(unit_or(tangent, glm::vec3(first)), first.w));
    }
    object_.push_back(object_[of[0]]);
    return std::uint32_t(g.vertices.size() - 1);
}

std::uint32_t TriangleSplit::on_edge(std::uint32_t a, std::uint32_t b, const glm::vec3& p) {
    if (a > b) std::swap(a, b);
    const glm::dvec3 from(geometry_.vertices[a].position), along = glm::dvec3(geometry_.vertices[b].position) - from;
    const double squared = glm::dot(along, along);
    const double share = squared > 0 ? std::clamp(glm::dot(glm::dvec3(p) - from, along) / squared, 0.0, 1.0) : 0.5;
    return mean({a, b, b}, {1 - share, share, 0}, p);
}

// [half edge]: the new vertex on it, shared where both ends are.
template <class Make>
std::vector<std::uint32_t> TriangleSplit::middles(const SurfaceMesh& m, const std::vector<char>& marked, const Make& make) {
    std::vector<std::uint32_t> out(3 * m.count, none);
    const auto vertex = [&](std::uint32_t h) { return geometry_.triangles[h / 3][int(h % 3)]; };
    for (std::size_t e = 0; e < marked.size(); ++e) {
        if (!marked[e]) continue;
        const std::uint32_t begin = m.edge_begin[e], end = m.edge_begin[e + 1];
        for (std::uint32_t i = begin; i < end; ++i) {
            const std::uint32_t h = m.half_edges[i], a = vertex(h), b = vertex(next_half_edge(h));
            for (std::uint32_t j = std::max(begin, i - std::min(i, farthest_back)); j < i && out[h] == none; ++j) {
                const std::uint32_t k = m.half_edges[j], c = vertex(k), d = vertex(next_half_edge(k));
                if ((a == c && b == d) || (a == d && b == c)) out[h] = out[k];
            }
            if (out[h] == none) out[h] = make(a, b, e);
        }
    }
    return out;
}

void TriangleSplit::append_parts(std::size_t t, const std::uint32_t* mid, Geometry& to,
                                 std::vector<std::uint32_t>& origin) const {
    const glm::uvec3 v = geometry_.triangles[t];
    int longest = -1;
    double longest_squared = -1;
    for (int k = 0; k < 3; ++k) {
        if (mid[k] == none) continue;
        const double s = squared_distance(geometry_.vertices[v[k]].position, geometry_.vertices[v[(k + 1) % 3]].position);
        if (s > longest_squared) longest = k, longest_squared = s;
    }
    const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        to.triangles.push_back({a, b, c});
        to.material.push_back(geometry_.material[t]), to.object.push_back(geometry_.object[t]);
        origin.push_back(origin_[t]);
    };
    if (longest < 0) return add(v.x, v.y, v.z);
    const std::uint32_t a = v[longest], b = v[(longest + 1) % 3], c = v[(longest + 2) % 3];
    const std::uint32_t ab = mid[longest], bc = mid[(longest + 1) % 3], ca = mid[(longest + 2) % 3];
    if (ca == none)
        add(a, ab, c);
    else
        add(a, ab, ca), add(ca, ab, c);
    if (bc == none)
        add(ab, b, c);
    else
        add(ab, b, bc), add(ab, bc, c);
}

void TriangleSplit::split(const SurfaceMesh& m, const std::vector<char>& marked) {
    split(m, marked, middles(m, marked, [&](std::uint32_t a, std::uint32_t b, std::size_t) { return middle(a, b); }));
}

void TriangleSplit::split_at(const SurfaceMesh& m, const std::vector<char>& marked, const std::vector<glm::vec3>& at) {
    split(m, marked, middles(m, marked, [&](std::uint32_t a, std::uint32_t b, std::size_t e) { return on_edge(a, b, at[e]); }));
}

void TriangleSplit::insert(const std::vector<Inside>& points) {
    Geometry& g = geometry_;
    for (const Inside& point : points) {
        const glm::uvec3 v = g.triangles[point.triangle];
        const glm::dvec3 a(g.vertices[v.x].position), e1 = glm::dvec3(g.vertices[v.y].position) - a, e2 = glm::dvec3(g.vertices[v.z].position) - a,
                         d = glm::dvec3(point.at) - a, n = glm::cross(e1, e2);
        const double area = glm::dot(n, n), beta = glm::dot(glm::cross(d, e2), n) / area, gamma = glm::dot(glm::cross(e1, d), n) / area;
        const std::uint32_t p = mean(v, {1 - beta - gamma, beta, gamma}, point.at);
        g.triangles[point.triangle] = {v.x, v.y, p};
        for (const glm::uvec3& part : {glm::uvec3(v.y, v.z, p), glm::uvec3(v.z, v.x, p)}) {
            g.triangles.push_back(part);
            g.material.push_back(g.material[point.triangle]), g.object.push_back(g.object[point.triangle]);
            origin_.push_back(origin_[point.triangle]);
        }
    }
}

void TriangleSplit::split(const SurfaceMesh& m, const std::vector<char>& marked, const std::vector<std::uint32_t>& mid) {
    const std::size_t count = count_after(m, marked);
    Geometry parts;
    std::vector<std::uint32_t> origin;
    parts.triangles.reserve(count), parts.material.reserve(count), parts.object.reserve(count), origin.reserve(count);
    for (std::size_t t = 0; t < m.count; ++t) append_parts(t, &mid[3 * t], parts, origin);
    geometry_.triangles = std::move(parts.triangles);
    geometry_.material = std::move(parts.material), geometry_.object = std::move(parts.object);
    origin_ = std::move(origin);
}

Scene TriangleSplit::take(const Scene& scene) {
    Scene out = scene;
    for (Mesh& mesh : out.meshes) {
        mesh.vertices.clear(), mesh.tangents.clear(), mesh.triangles.clear(), mesh.material.clear();
        mesh.transform = glm::dmat4(1), mesh.share = 1;
    }
    out.animation.meshes.clear();  // they would move meshes from where these were made
    std::vector<std::uint32_t> place(geometry_.vertices.size());
    for (std::size_t v = 0; v < place.size(); ++v) {
        Mesh& mesh = out.meshes[std::size_t(object_[v])];
        place[v] = std::uint32_t(mesh.vertices.size());
        mesh.vertices.push_back(geometry_.vertices[v]);
        if (!geometry_.tangents.empty() && !scene.meshes[std::size_t(object_[v])].tangents.empty())
            mesh.tangents.push_back(geometry_.tangents[v]);
    }
    for (std::size_t t = 0; t < geometry_.triangles.size(); ++t) {
        const glm::uvec3 v = geometry_.triangles[t];
        Mesh& mesh = out.meshes[std::size_t(geometry_.object[t])];
        mesh.triangles.push_back({place[v.x], place[v.y], place[v.z]});
        mesh.material.push_back(geometry_.material[t]);
    }
    return out;
}

}  // namespace plumb::radiosity
