#include "gi/radiosity/contacts.h"

#include <algorithm>
#include <cmath>

#include "gi/radiosity/surface_points.h"

namespace plumb::radiosity {
namespace {

using probes::next_half_edge;
using probes::SurfaceMesh;

class Inspection {
  public:
    explicit Inspection(const Geometry& g) : geometry_(g), mesh_(probes::surface_mesh(g, 0, 0, g.triangles.size())) {
        out_.tolerance_m = meeting_distance(mesh_);
    }

    Contacts run() {
        if (mesh_.half_edges.empty()) return out_;
        junctions();
        contacts();
        return std::move(out_);
    }

  private:
    std::size_t edges() const { return mesh_.edge_begin.size() - 1; }
    std::uint32_t first_of(std::size_t e) const { return mesh_.half_edges[mesh_.edge_begin[e]]; }
    Point start(std::uint32_t h) const { return Point(mesh_.corner(h).position); }

    void junctions() {
        std::vector<Point> points(mesh_.points);
        for (std::uint32_t h : mesh_.half_edges) points[mesh_.point[h]] = start(h);
        const PointTree tree(points);
        std::vector<char> inside(points.size(), 0);
        const double tolerance = out_.tolerance_m;
        for (std::size_t e = 0; e < edges(); ++e) {
            const std::uint32_t h = first_of(e);
            const Point a = start(h), b = start(next_half_edge(h)), along = (b - a) / length(b - a);
            tree.query(Box(a, b, tolerance), [&](std::uint32_t i) {
                const Point to = tree[i] - a;
                const double at = glm::dot(to, along);
                if (at > tolerance && at < length(b - a) - tolerance && length(to - at * along) <= tolerance) inside[i] = 1;
            });
        }
        for (char c : inside) out_.t_junctions += c;
        for (std::uint32_t i = 0; i < points.size(); ++i) {
            bool twin = false;
            tree.query(Box(points[i], points[i], tolerance), [&](std::uint32_t j) { twin = twin || j != i; });
            out_.nearly_equal += twin;
        }
    }

    bool belongs_to(std::size_t e, std::int32_t object) const {
        for (std::uint32_t i = mesh_.edge_begin[e]; i < mesh_.edge_begin[e + 1]; ++i)
            if (geometry_.object[mesh_.half_edges[i] / 3] == object) return true;
        return false;
    }

    void contacts() {
        std::vector<Point> points;  // two an edge
        for (std::size_t e = 0; e < edges(); ++e) {
            const Point a = start(first_of(e)), b = start(next_half_edge(first_of(e)));
            points.push_back(0.75 * a + 0.25 * b), points.push_back(0.25 * a + 0.75 * b);
        }
        const PointTree tree(std::move(points));
        const auto for_points_on = [&](std::size_t t, const auto& f) {
            const Box box(mesh_.position(t, 0), mesh_.position(t, 1), mesh_.position(t, 2), out_.tolerance_m);
            tree.query(box, [&](std::uint32_t i) {
                const Where where = where_on(mesh_, t, tree[i], out_.tolerance_m);
                if (where != off_it && !belongs_to(i / 2, geometry_.object[t])) f(i, where);
            });
        };
        std::vector<char> where(2 * edges(), off_it);
        for (std::size_t t = 0; t < mesh_.count; ++t)
            if (mesh_.area[t] > 0)
                for_points_on(t, [&](std::uint32_t i, Where w) { where[i] = std::max(where[i], char(w)); });
        std::vector<char> touches(edges(), 0);
        for (std::size_t e = 0; e < edges(); ++e) {
            const char low = std::min(where[2 * e], where[2 * e + 1]), high = std::max(where[2 * e], where[2 * e + 1]);
            touches[e] = low != off_it && high == within;
            out_.contacts += touches[e];
        }
        for (std::uint32_t t = 0; t < mesh_.count; ++t)
            if (mesh_.area[t] > 0 && std::any_of(&mesh_.edge_of[3 * t], &mesh_.edge_of[3 * t] + 3, [&](std::uint32_t e) { return touches[e] != 0; }))
                out_.standing.push_back(t);
        for (std::size_t t = 0; t < mesh_.count; ++t) {
            bool met = false;
            if (mesh_.area[t] > 0)
                for_points_on(t, [&](std::uint32_t i, Where w) { met = met || (w == within && touches[i / 2]); });
            if (met) out_.triangles.push_back(std::uint32_t(t));
        }
    }

    const Geometry& geometry_;
    SurfaceMesh mesh_;
    Contacts out_;
};

}  // namespace

Contacts inspect_contacts(const Geometry& geometry) { return Inspection(geometry).run(); }

}  // namespace plumb::radiosity
