#include "core/tangents.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <numeric>

#include "core/host_math.h"

namespace plumb {
namespace {

using Ids = std::vector<std::uint32_t>;

struct TriangleFrame {
    glm::dvec3 tangent{0};  // unit: direction of increasing u; 0 where there is none
    int orientation = 0;    // +1 where (u, -v) turns as the corners do, -1 mirrored, 0: no area in the image
};

double length(const glm::dvec3& v) { return __builtin_sqrt(glm::dot(v, v)); }

glm::dvec3 unit_or_zero(const glm::dvec3& v) {
    const double l = length(v);
    return l > 0 && l - l == 0 ? v / l : glm::dvec3(0);
}

// The part of v across unit normal n, made unit.
glm::dvec3 across(const glm::dvec3& v, const glm::dvec3& n) { return unit_or_zero(v - n * glm::dot(n, v)); }

// For every vertex the first one with the same position, normal and coordinates: seams of indexing alone are none.
Ids weld(const std::vector<Vertex>& vertices) {
    auto key = [&](std::uint32_t i) {
        std::array<std::int32_t, 8> bits;
        std::memcpy(bits.data(), &vertices[i], sizeof bits);
        for (std::int32_t& b : bits)
            if (std::uint32_t(b) == 0x80000000u) b = 0;  // -0 is 0
        return bits;
    };
    Ids order(vertices.size()), first(vertices.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        const auto ka = key(a), kb = key(b);
        return ka != kb ? ka < kb : a < b;
    });
    for (std::size_t k = 0; k < order.size(); ++k)
        first[order[k]] = k > 0 && key(order[k]) == key(order[k - 1]) ? first[order[k - 1]] : order[k];
    return first;
}

// dP/du of the plane through the corners: with edges e and their steps (du, dv), (dv2 e1 - dv1 e2) / (du1 dv2 - du2 dv1).
TriangleFrame frame_of(const Vertex& a, const Vertex& b, const Vertex& c) {
    const glm::dvec3 e1 = glm::dvec3(b.position) - glm::dvec3(a.position);
    const glm::dvec3 e2 = glm::dvec3(c.position) - glm::dvec3(a.position);
    const double du1 = double(b.u) - a.u, dv1 = double(b.v) - a.v, du2 = double(c.u) - a.u, dv2 = double(c.v) - a.v;
    const double area = du1 * dv2 - du2 * dv1;
    if (length(glm::cross(e1, e2)) > 0 && area != 0 && area - area == 0)
        return {unit_or_zero((e1 * dv2 - e2 * dv1) * (area > 0 ? 1.0 : -1.0)), area > 0 ? -1 : 1};
    return {};
}

struct Builder {
    Mesh& mesh;
    Ids welded;
    std::vector<TriangleFrame> frames;   // [triangle]
    Ids start, corners;                  // corners of welded vertex v: corners[start[v]] .. corners[start[v + 1] - 1]
    std::vector<glm::vec4> tangents;     // [corner]

    std::uint32_t vertex(std::uint32_t corner) const { return mesh.triangles[corner / 3][int(corner % 3)]; }
    std::uint32_t next(std::uint32_t corner) const { return corner - corner % 3 + (corner + 1) % 3; }
    std::uint32_t previous(std::uint32_t corner) const { return corner - corner % 3 + (corner + 2) % 3; }
    std::uint32_t id(std::uint32_t corner) const { return welded[vertex(corner)]; }

    void list_corners() {
        const std::uint32_t count = std::uint32_t(3 * mesh.triangles.size());
        start.assign(mesh.vertices.size() + 1, 0);
        for (std::uint32_t c = 0; c < count; ++c) ++start[id(c) + 1];
        std::partial_sum(start.begin(), start.end(), start.begin());
        corners.resize(count);
        Ids at(start.begin(), start.end() - 1);
        for (std::uint32_t c = 0; c < count; ++c) corners[at[id(c)]++] = c;
    }

    // A triangle without an area in the image adds nothing, and takes the orientation of the first triangle around it
    // that has one.
    void orient_degenerate() {
        const std::vector<TriangleFrame> known = frames;
        for (std::uint32_t t = 0; t < frames.size(); ++t) {
            if (frames[t].orientation != 0) continue;
            std::uint32_t first = std::uint32_t(frames.size());
            for (std::uint32_t c = 3 * t; c < 3 * t + 3; ++c)
                for (std::uint32_t k = start[id(c)]; k < start[id(c) + 1]; ++k)
                    if (known[corners[k] / 3].orientation != 0) first = std::min(first, corners[k] / 3);
            frames[t].orientation = first < frames.size() ? known[first].orientation : 1;
        }
    }

    // What a corner adds to its group: its triangle's tangent in the plane across the normal, weighted by the angle that
    // its edges span in that plane.
    glm::dvec3 share(std::uint32_t corner) const {
        const glm::dvec3 n = unit_or_zero(glm::dvec3(mesh.vertices[vertex(corner)].normal));
        const glm::dvec3 p(mesh.vertices[vertex(corner)].position);
        const glm::dvec3 a = across(glm::dvec3(mesh.vertices[vertex(next(corner))].position) - p, n);
        const glm::dvec3 b = across(glm::dvec3(mesh.vertices[vertex(previous(corner))].position) - p, n);
        const double angle = host::acos(std::clamp(glm::dot(a, b), -1.0, 1.0));
        return across(frames[corner / 3].tangent, n) * angle;
    }

    // Corners around a vertex form a group where their triangles share an edge at it and turn the same way. An edge
    // leads from one triangle to one other: out of `corner` along next() is into its neighbour along previous().
    void solve_vertex(std::uint32_t first, std::uint32_t last) {
        using Key = std::array<std::uint32_t, 3>;  // orientation, vertex at the edge's other end, place in the list
        const std::uint32_t count = last - first;
        std::vector<Key> out, in;
        Ids group(count);
        std::iota(group.begin(), group.end(), 0u);
        for (std::uint32_t k = 0; k < count; ++k) {
            const std::uint32_t c = corners[first + k], orientation = frames[c / 3].orientation > 0;
            out.push_back({orientation, id(next(c)), k});
            in.push_back({orientation, id(previous(c)), k});
        }
        auto root = [&](std::uint32_t k) {
            while (group[k] != k) k = group[k] = group[group[k]];
            return k;
        };
        std::sort(out.begin(), out.end());
        std::sort(in.begin(), in.end());
        for (std::size_t o = 0, i = 0; o < out.size() && i < in.size();) {
            const Key a{out[o][0], out[o][1], 0}, b{in[i][0], in[i][1], 0};
            if (a == b) {
                const std::uint32_t ra = root(out[o][2]), rb = root(in[i][2]);
                group[std::max(ra, rb)] = std::min(ra, rb);
            }
            o += a <= b, i += b <= a;
        }
        std::vector<glm::dvec3> sum(count, glm::dvec3(0));
        for (std::uint32_t k = 0; k < count; ++k) sum[root(k)] += share(corners[first + k]);
        for (std::uint32_t k = 0; k < count; ++k) {
            const std::uint32_t c = corners[first + k];
            const glm::dvec3 t = unit_or_zero(sum[root(k)]);
            const float side = t == glm::dvec3(0) ? 1.0f : float(frames[c / 3].orientation);
            tangents[c] = t == glm::dvec3(0) ? glm::vec4(1, 0, 0, 1) : glm::vec4(glm::vec3(t), side);
        }
    }

    // Gives each vertex the tangent of its first corner, and each corner with another one a vertex that has it.
    void split() {
        const std::size_t originals = mesh.vertices.size();
        std::vector<bool> taken(originals, false);
        std::vector<Ids> copies(originals);  // further vertices of each one
        mesh.tangents.assign(originals, glm::vec4(1, 0, 0, 1));
        for (std::uint32_t c = 0; c < tangents.size(); ++c) {
            const std::uint32_t v = vertex(c);
            if (!taken[v]) taken[v] = true, mesh.tangents[v] = tangents[c];
            if (mesh.tangents[v] == tangents[c]) continue;
            auto same = [&](std::uint32_t copy) { return mesh.tangents[copy] == tangents[c]; };
            auto found = std::find_if(copies[v].begin(), copies[v].end(), same);
            if (found == copies[v].end()) {
                found = copies[v].insert(found, std::uint32_t(mesh.vertices.size()));
                mesh.vertices.push_back(Vertex(mesh.vertices[v]));
                mesh.tangents.push_back(tangents[c]);
            }
            mesh.triangles[c / 3][int(c % 3)] = *found;
        }
    }
};

}  // namespace

void generate_tangents(Mesh& mesh) {
    Builder b{mesh, weld(mesh.vertices), {}, {}, {}, std::vector<glm::vec4>(3 * mesh.triangles.size())};
    for (const glm::uvec3& t : mesh.triangles)
        b.frames.push_back(frame_of(mesh.vertices[t.x], mesh.vertices[t.y], mesh.vertices[t.z]));
    b.list_corners();
    b.orient_degenerate();
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
        if (b.start[v] < b.start[v + 1]) b.solve_vertex(b.start[v], b.start[v + 1]);
    b.split();
}

}  // namespace plumb
