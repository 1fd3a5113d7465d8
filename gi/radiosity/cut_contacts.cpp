#include "gi/radiosity/cut_contacts.h"

#include <optional>

#include "gi/radiosity/surface_points.h"
#include "gi/radiosity/triangle_split.h"

namespace plumb::radiosity {
namespace {

using probes::next_half_edge;
using probes::SurfaceMesh;

constexpr int most_rounds = 1000;  // an edge over n triangles takes some log n

bool before(const glm::vec3& a, const glm::vec3& b) {
    return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
}

// What was offered nearest to the middle, the same whatever the order: of n points the others are on either side of it, and all
// have had their turn in some log n rounds.
struct Middlemost {
    std::optional<glm::vec3> at;
    double distance2 = 0;
    void offer(const glm::vec3& p, const Point& middle) {
        const Point d = Point(p) - middle;
        const double size2 = glm::dot(d, d);
        if (!at || size2 < distance2 || (size2 == distance2 && before(p, *at))) at = p, distance2 = size2;
    }
};

struct Edge {
    glm::vec3 a{0}, b{0};  // in their order
    Edge(const glm::vec3& p, const glm::vec3& q) : a(before(p, q) ? p : q), b(before(p, q) ? q : p) {}
    Point along() const { return Point(b) - Point(a); }
};

// Where two edges of one plane cross: the point of `one` next to the other's line.
glm::vec3 crossing(const Edge& one, const Edge& other) {
    const Point u = one.along(), v = other.along(), w = Point(one.a) - Point(other.a);
    const double uu = glm::dot(u, u), uv = glm::dot(u, v), vv = glm::dot(v, v), uw = glm::dot(u, w), vw = glm::dot(v, w);
    return glm::vec3(Point(one.a) + u * ((uv * vw - vv * uw) / (uu * vv - uv * uv)));
}

// What one round does.
class Round {
  public:
    explicit Round(const TriangleSplit& triangles)
        : mesh_(triangles.edges()), tolerance_(meeting_distance(mesh_)), least_(128 * tolerance_), on_edge_(edges()), inside_(mesh_.count) {
        find_points(), find_standing();
        const PointTree tree(points_);
        std::vector<Box> boxes;
        for (std::uint32_t e : standing_) boxes.emplace_back(start(first_of(e)), end(first_of(e)), 0.0);
        const BoxTree edge_tree(std::move(boxes));
        for (std::size_t t = 0; t < mesh_.count; ++t) {
            if (!(height(t) > least_)) continue;
            meet_points(t, tree);
            meet_edges(t, edge_tree);
        }
    }

    // False where nothing is left to do.
    bool apply(TriangleSplit& triangles, Cut& cut, std::int64_t most) const {
        std::vector<TriangleSplit::Inside> points;
        for (std::uint32_t t = 0; t < inside_.size(); ++t)
            if (inside_[t].at) points.push_back({t, *inside_[t].at});
        if (!points.empty()) {
            require_at_most(mesh_.count + 2 * points.size(), most);
            triangles.insert(points);
            cut.inside += std::int64_t(points.size());
            return true;
        }
        std::vector<char> marked(edges(), 0);
        std::vector<glm::vec3> at(edges());
        bool any = false;
        for (std::uint32_t e = 0; e < marked.size(); ++e)
            if (on_edge_[e].at) marked[e] = 1, at[e] = *on_edge_[e].at, any = true;
        if (!any) return false;
        require_at_most(triangles.count_after(mesh_, marked), most);
        triangles.split_at(mesh_, marked, at);
        cut.corners += corners_, cut.crossings += crossings_;
        return true;
    }

  private:
    std::size_t edges() const { return mesh_.edge_begin.size() - 1; }
    std::uint32_t first_of(std::size_t e) const { return mesh_.half_edges[mesh_.edge_begin[e]]; }
    const glm::vec3& start_f(std::uint32_t h) const { return mesh_.corner(h).position; }
    const glm::vec3& end_f(std::uint32_t h) const { return mesh_.corner(next_half_edge(h)).position; }
    Point start(std::uint32_t h) const { return Point(start_f(h)); }
    Point end(std::uint32_t h) const { return Point(end_f(h)); }
    double above(std::size_t t, const Point& p) const { return glm::dot(p - mesh_.position(t, 0), mesh_.normal[t]); }
    // Of a triangle over its longest edge: what is lower than the least piece is not cut, for all that lies beside it is on two of its edges.
    double height(std::size_t t) const {
        const auto h = std::uint32_t(3 * t);
        return 2 * mesh_.area[t] / std::max({length(end(h) - start(h)), length(end(h + 1) - start(h + 1)), length(end(h + 2) - start(h + 2))});
    }
    bool in_plane(std::size_t t, const Point& p) const { return std::fabs(above(t, p)) <= tolerance_; }

    void find_points() {
        points_.resize(mesh_.points), position_.resize(mesh_.points);
        for (std::uint32_t h : mesh_.half_edges) position_[mesh_.point[h]] = start_f(h), points_[mesh_.point[h]] = start(h);
    }

    // Edges that triangles of one plane do not go on beyond, and the points at their ends.
    void find_standing() {
        edges_at_.resize(mesh_.points), stands_.assign(edges(), 0);
        for (std::uint32_t e = 0; e < edges(); ++e) {
            const std::uint32_t begin = mesh_.edge_begin[e], end = mesh_.edge_begin[e + 1], h = mesh_.half_edges[begin];
            if (end - begin > 1 && !rises_from(e, h / 3)) continue;
            standing_.push_back(e), stands_[e] = 1;
            edges_at_[mesh_.point[h]].push_back(e), edges_at_[mesh_.point[next_half_edge(h)]].push_back(e);
        }
    }
    // Whether a triangle at the edge leaves the plane of t.
    bool rises_from(std::uint32_t e, std::size_t t) const {
        for (std::uint32_t i = mesh_.edge_begin[e]; i < mesh_.edge_begin[e + 1]; ++i)
            if (!in_plane(t, start(next_half_edge(next_half_edge(mesh_.half_edges[i]))))) return true;
        return false;
    }

    bool is_corner(std::size_t t, std::uint32_t point) const {
        return mesh_.point[3 * t] == point || mesh_.point[3 * t + 1] == point || mesh_.point[3 * t + 2] == point;
    }

    // Corners of others that lie in the triangle, or on its edges.
    void meet_points(std::size_t t, const PointTree& tree) {
        const Box box(mesh_.position(t, 0), mesh_.position(t, 1), mesh_.position(t, 2), tolerance_);
        tree.query(box, [&](std::uint32_t i) {
            if (is_corner(t, i)) return;
            const Where where = where_on(mesh_, t, points_[i], tolerance_);
            if (where == within && stands_on(i, t)) inside_[t].offer(position_[i], middle_of(t));
            if (where == at_border) meet_border(t, i);
        });
    }
    bool stands_on(std::uint32_t point, std::size_t t) const {
        return std::any_of(edges_at_[point].begin(), edges_at_[point].end(), [&](std::uint32_t e) { return rises_from(e, t); });
    }
    // Edges on both sides of which the surface goes on are divided by what stands there alone: not by corners of another surface that lies on it.
    void meet_border(std::size_t t, std::uint32_t point) {
        const bool stands = stands_on(point, t);
        for (std::uint32_t h = std::uint32_t(3 * t); h < 3 * t + 3; ++h) {
            const std::uint32_t e = mesh_.edge_of[h];
            if (!stands_[e] && !stands) continue;
            const Point along = end(h) - start(h), to = points_[point] - start(h);
            const double size = length(along), at = glm::dot(to, along) / size;
            if (at > least_ && at < size - least_ && length(to - along * (at / size)) <= tolerance_)
                offer(e, position_[point], corners_);
        }
    }

    // Edges of others that lie in the triangle's plane, stand off it, and cross its edges.
    void meet_edges(std::size_t t, const BoxTree& tree) {
        const Box box(mesh_.position(t, 0), mesh_.position(t, 1), mesh_.position(t, 2), tolerance_);
        tree.query(box, [&](std::uint32_t i) {
            const std::uint32_t e = standing_[i], h = first_of(e);
            if (!in_plane(t, start(h)) || !in_plane(t, end(h)) || !rises_from(e, t)) return;
            for (std::uint32_t own = std::uint32_t(3 * t); own < 3 * t + 3; ++own) meet_edge(t, own, h);
        });
    }
    void meet_edge(std::size_t t, std::uint32_t own, std::uint32_t other) {
        const std::uint32_t p = mesh_.point[own], q = mesh_.point[next_half_edge(own)], r = mesh_.point[other], s = mesh_.point[next_half_edge(other)];
        if (p == r || p == s || q == r || q == s) return;
        const auto parts = [&](std::uint32_t line, std::uint32_t ends) {
            const Point along = end(line) - start(line), across = glm::cross(mesh_.normal[t], along) / length(along);
            const double a = glm::dot(start(ends) - start(line), across), b = glm::dot(end(ends) - start(line), across);
            return std::min(a, b) < -tolerance_ && std::max(a, b) > tolerance_;
        };
        if (!parts(own, other) || !parts(other, own)) return;
        const glm::vec3 at = crossing({start_f(other), end_f(other)}, {start_f(own), end_f(own)});
        if (length(Point(at) - start(own)) > least_ && length(Point(at) - end(own)) > least_) offer(mesh_.edge_of[own], at, crossings_);
    }
    // An edge that has a point already keeps the one nearer to its middle, and is divided at the other in a later round.
    void offer(std::uint32_t e, const glm::vec3& at, std::int64_t& count) {
        count += !on_edge_[e].at;
        on_edge_[e].offer(at, (start(first_of(e)) + end(first_of(e))) * 0.5);
    }
    Point middle_of(std::size_t t) const { return (Point(mesh_.position(t, 0)) + Point(mesh_.position(t, 1)) + Point(mesh_.position(t, 2))) / 3.0; }

    SurfaceMesh mesh_;
    double tolerance_, least_;
    std::vector<Middlemost> on_edge_;  // [edge]
    std::vector<Middlemost> inside_;   // [triangle]
    std::vector<Point> points_;
    std::vector<glm::vec3> position_;
    std::vector<std::uint32_t> standing_;
    std::vector<char> stands_;  // [edge]
    std::vector<std::vector<std::uint32_t>> edges_at_;  // [point]: those that stand
    std::int64_t corners_ = 0, crossings_ = 0;
};

}  // namespace

Cut cut_contacts(const Scene& scene, std::int64_t most_triangles) {
    TriangleSplit triangles(scene);
    Cut cut;
    while (cut.rounds < most_rounds && Round(triangles).apply(triangles, cut, most_triangles)) ++cut.rounds;
    cut.scene = triangles.take(scene);
    return cut;
}

}  // namespace plumb::radiosity
