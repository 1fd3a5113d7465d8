#include "gi/radiosity/tessellate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "gi/radiosity/contacts.h"
#include "gi/radiosity/triangle_split.h"

namespace plumb::radiosity {
namespace {

using probes::next_half_edge;
using probes::SurfaceMesh;
using Colour = glm::dvec3;

void check_length(const char* name, double m) {
    if (!(m > 0 && m < 1e30)) throw InputError(fmt::format("radiosity: {} = {}: expected a length above 0 m", name, m));
}

void check_positions(const Geometry& g) {
    if (g.triangles.empty()) throw InputError("radiosity: the scene has no triangles");
    for (const glm::uvec3& t : g.triangles)
        for (int k = 0; k < 3; ++k) {
            const glm::vec3& p = g.vertices[t[k]].position;
            if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
                throw InputError("radiosity: a position is not finite");
        }
}

// ---- Differences -----------------------------------------------------------------------------------------------------

void check_radiosity(const Elements& e, const Buffer<glm::vec4>& radiosity) {
    if (radiosity.size() != e.position.size())
        throw InputError(fmt::format("radiosity: {} values for {} elements", radiosity.size(), e.position.size()));
    for (const glm::vec4& b : radiosity)
        if (!std::isfinite(b.x) || !std::isfinite(b.y) || !std::isfinite(b.z))
            throw InputError("radiosity: a value is not finite");
}

Colour mean_by_area(const Elements& e, const Buffer<glm::vec4>& radiosity) {
    Colour sum(0);
    double area = 0;
    for (std::size_t i = 0; i < radiosity.size(); ++i) sum += e.area[i] * Colour(radiosity[i]), area += e.area[i];
    return area > 0 ? sum / area : Colour(0);
}

double luminance(const Colour& c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }

class Range {
  public:
    void add(const glm::vec4& b) {
        const Colour c(b);
        const double values[4] = {c.x, c.y, c.z, luminance(c)};
        for (int s = 0; s < 4; ++s) {
            low_[s] = count_ ? std::min(low_[s], values[s]) : values[s];
            high_[s] = count_ ? std::max(high_[s], values[s]) : values[s];
            sum_[s] += values[s];
        }
        ++count_;
    }
    double difference(const Colour& least) const {
        const double floor[4] = {least.x, least.y, least.z, luminance(least)};
        double relative[4];
        for (int s = 0; s < 4; ++s) {
            const double mean = std::max(sum_[s] / count_, floor[s]);
            relative[s] = mean > 0 ? (high_[s] - low_[s]) / mean : 0;
        }
        const double squares = relative[0] * relative[0] + relative[1] * relative[1] + relative[2] * relative[2];
        return std::max(relative[3], std::sqrt(squares / 3));
    }

  private:
    double low_[4], high_[4], sum_[4] = {};
    int count_ = 0;
};

// Calls f for the triangles beside t that are of the same object and material.
template <class F>
void for_neighbours(const Geometry& g, const SurfaceMesh& m, std::size_t t, const F& f) {
    for (std::size_t h = 3 * t; h < 3 * t + 3; ++h)
        for (std::uint32_t i = m.edge_begin[m.edge_of[h]]; i < m.edge_begin[m.edge_of[h] + 1]; ++i) {
            const std::size_t s = m.half_edges[i] / 3;
            if (s != t && g.object[s] == g.object[t] && g.material[s] == g.material[t]) f(s);
        }
}

// ---- Marks -----------------------------------------------------------------------------------------------------------

class Marks {
  public:
    Marks(const SurfaceMesh& mesh, double least_edge) : mesh_(mesh) {
        const std::size_t edges = mesh.edge_begin.size() - 1;
        marked_.assign(edges, 0), squared_.resize(edges), may_.resize(edges);
        for (std::uint32_t e = 0; e < edges; ++e) {
            squared_[e] = TriangleSplit::squared_length(mesh, e);
            may_[e] = squared_[e] >= 4 * least_edge * least_edge && TriangleSplit::can_split(mesh, e);
        }
    }
    // All edges of a triangle that may be split; false where none may.
    bool mark_triangle(std::size_t t) {
        bool any = false;
        for (std::size_t h = 3 * t; h < 3 * t + 3; ++h)
            if (may_[mesh_.edge_of[h]]) mark(mesh_.edge_of[h]), any = true;
        return any;
    }
    // Marks the longest edge of every triangle that has one marked.
    void close() {
        while (!open_.empty()) {
            const std::uint32_t e = open_.back();
            open_.pop_back();
            for (std::uint32_t i = mesh_.edge_begin[e]; i < mesh_.edge_begin[e + 1]; ++i) mark_longest(mesh_.half_edges[i] / 3);
        }
    }
    bool any_at(std::size_t t) const {
        return marked_[mesh_.edge_of[3 * t]] || marked_[mesh_.edge_of[3 * t + 1]] || marked_[mesh_.edge_of[3 * t + 2]];
    }
    const std::vector<char>& edges() const { return marked_; }

  private:
    void mark(std::uint32_t e) {
        if (marked_[e]) return;
        marked_[e] = 1;
        open_.push_back(e);
    }
    void mark_longest(std::size_t t) {
        std::uint32_t longest = mesh_.edge_of[3 * t];
        for (std::size_t h = 3 * t + 1; h < 3 * t + 3; ++h) {
            const std::uint32_t e = mesh_.edge_of[h];
            const bool longer = squared_[e] > squared_[longest];
            if (longer || (squared_[e] == squared_[longest] && marked_[e])) longest = e;
        }
        if (may_[longest]) mark(longest);
    }

    const SurfaceMesh& mesh_;
    std::vector<char> marked_, may_;  // [edge]
    std::vector<double> squared_;     // [edge]: length, m2
    std::vector<std::uint32_t> open_;
};

}  // namespace

Scene tessellate(const Scene& scene, const TessellateParams& params) {
    check_length("longest_edge", params.longest_edge);
    TriangleSplit triangles(scene);
    check_positions(triangles.geometry());
    require_at_most(triangles.geometry().triangles.size(), params.most_triangles);
    while (true) {
        const SurfaceMesh edges = triangles.edges();
        std::vector<char> marked(edges.edge_begin.size() - 1);
        bool any = false;
        for (std::uint32_t e = 0; e < marked.size(); ++e) {
            marked[e] = TriangleSplit::squared_length(edges, e) > params.longest_edge * params.longest_edge &&
                        TriangleSplit::can_split(edges, e);
            any = any || marked[e];
        }
        if (!any) return triangles.take(scene);
        require_at_most(triangles.count_after(edges, marked), params.most_triangles);
        triangles.split(edges, marked);
    }
}

std::vector<double> differences(const Elements& e, const Buffer<glm::vec4>& radiosity, double dark) {
    check_radiosity(e, radiosity);
    const Colour least = dark * mean_by_area(e, radiosity);
    SurfaceMesh mesh;
    if (e.kind == Kind::triangles)
        mesh = probes::surface_mesh(e.geometry, 0, 0, e.geometry.triangles.size(), true);
    std::vector<double> out(e.of.size());
    for (std::size_t t = 0; t < out.size(); ++t) {
        Range range;
        for (int k = 0; k < 3; ++k) range.add(radiosity[e.of[t][k]]);
        if (e.kind == Kind::triangles) for_neighbours(e.geometry, mesh, t, [&](std::size_t s) { range.add(radiosity[s]); });
        out[t] = range.difference(least);
    }
    return out;
}

Refined refine(const Scene& scene, const Elements& elements, const Buffer<glm::vec4>& radiosity, const RefineParams& params) {
    check_length("least_edge", params.least_edge);
    if (!(params.tolerance >= 0)) throw InputError(fmt::format("radiosity: tolerance = {}: expected 0 or more", params.tolerance));
    if (!(params.dark >= 0)) throw InputError(fmt::format("radiosity: dark = {}: expected 0 or more", params.dark));
    const std::vector<double> difference = differences(elements, radiosity, params.dark);
    TriangleSplit triangles(scene);
    if (triangles.geometry().triangles != elements.geometry.triangles)
        throw InputError("radiosity: the elements are another scene's");
    check_positions(triangles.geometry());

    const SurfaceMesh edges = triangles.edges();
    Marks marks(edges, params.least_edge);
    std::vector<char> own(difference.size(), 0);
    Refined out;
    for (std::size_t t = 0; t < difference.size(); ++t) {
        if (!(difference[t] > params.tolerance)) continue;
        own[t] = marks.mark_triangle(t);
        ++(own[t] ? out.different : out.at_least_edge);
    }
    if (params.contacts) {
        // Both: the edge gets as short as the triangles below it, and so finds them all.
        const Contacts contacts = inspect_contacts(triangles.geometry());
        for (const auto* list : {&contacts.triangles, &contacts.standing})
            for (std::uint32_t t : *list)
                if (!own[t] && marks.mark_triangle(t)) own[t] = 1, ++out.at_contacts;
    }
    marks.close();
    for (std::size_t t = 0; t < own.size(); ++t) out.beside += !own[t] && marks.any_at(t);
    require_at_most(triangles.count_after(edges, marks.edges()), params.most_triangles);
    triangles.split(edges, marks.edges());
    out.origin = triangles.origin();
    out.scene = triangles.take(scene);
    return out;
}

}  // namespace plumb::radiosity
