#include "gi/probes/planar_charts.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include "core/host_math.h"
#include "gi/probes/plane_cover.h"

namespace plumb::probes {
namespace {

using List = std::vector<std::uint32_t>;

glm::dvec3 unit(const glm::dvec3& v) { return v / std::sqrt(glm::dot(v, v)); }

// The triangles projected onto the plane across n, with the seed's first corner as origin.
class Projection {
  public:
    Projection(const SurfaceMesh& mesh, std::uint32_t seed, const glm::dvec3& n)
        : mesh_(mesh), origin_(mesh.position(seed, 0)) {
        plane_axes(n, first_, second_);
    }
    PlaneTriangle operator()(std::uint32_t t) const {
        PlaneTriangle p;
        for (int k = 0; k < 3; ++k) {
            const glm::dvec3 d = mesh_.position(t, k) - origin_;
            p[std::size_t(k)] = {glm::dot(d, first_), glm::dot(d, second_)};
        }
        return p;
    }

  private:
    const SurfaceMesh& mesh_;
    glm::dvec3 origin_, first_, second_;
};

double cosine(double angle_deg) { return host::cos(angle_deg * host::pi / 180); }

// Of positions, m: four of their roundings.
double overlap_tolerance(const SurfaceMesh& mesh) {
    double largest = 0;
    for (std::size_t t = 0; t < mesh.count; ++t)
        for (int k = 0; k < 3 && mesh.area[t] > 0; ++k)
            for (int c = 0; c < 3; ++c) largest = std::max(largest, std::fabs(mesh.position(t, k)[c]));
    return largest * 0x1p-22;
}

double area_of(const SurfaceMesh& mesh, const List& triangles) {
    double sum = 0;
    for (std::uint32_t t : triangles) sum += mesh.area[t];
    return sum;
}

// Calls visit(neighbour, half edge of t) for triangles that carry the surface on across an edge of t.
template <class Visit>
void for_neighbours(const SurfaceMesh& mesh, std::uint32_t t, const Visit& visit) {
    for (std::uint32_t h = 3 * t; h < 3 * t + 3; ++h) {
        const std::uint32_t e = mesh.edge_of[h];
        if (mesh.edge_begin[e + 1] - mesh.edge_begin[e] > 8) continue;
        for (std::uint32_t i = mesh.edge_begin[e]; i < mesh.edge_begin[e + 1]; ++i) {
            const std::uint32_t other = mesh.half_edges[i];
            if (mesh.point[other] != mesh.point[h]) visit(other / 3, h);
        }
    }
}

// A chart that takes further triangles as long as they do not overlap.
PlaneCover cover_of(const Projection& project, const List& triangles, double tolerance) {
    glm::dvec2 low(HUGE_VAL), high(-HUGE_VAL);
    for (std::uint32_t t : triangles)
        for (const glm::dvec2& p : project(t)) low = glm::min(low, p), high = glm::max(high, p);
    return PlaneCover(low, high, triangles.size(), tolerance);
}

std::vector<PlaneTriangle> projected(const Projection& project, const List& triangles) {
    std::vector<PlaneTriangle> plane;
    for (std::uint32_t t : triangles) plane.push_back(project(t));
    return plane;
}

struct GrownChart {
    glm::dvec3 normal;
    List triangles;
};

class Grower {
  public:
    Grower(const SurfaceMesh& mesh, double angle_deg, double tolerance)
        : mesh_(mesh),
          least_cosine_(cosine(angle_deg)),
          tolerance_(tolerance),
          mark_(mesh.count, 0),
          taken_(mesh.count, 0) {}

    std::vector<GrownChart> grow_all() {
        List seeds;
        for (std::uint32_t t = 0; t < mesh_.count; ++t)
            if (mesh_.area[t] > 0) seeds.push_back(t);
        std::sort(seeds.begin(), seeds.end(), [&](std::uint32_t a, std::uint32_t b) {
            return mesh_.area[a] != mesh_.area[b] ? mesh_.area[a] > mesh_.area[b] : a < b;
        });
        std::vector<GrownChart> charts;
        for (std::uint32_t seed : seeds) {
            if (taken_[seed]) continue;
            charts.push_back(chart_from(seed));
            for (std::uint32_t t : charts.back().triangles) taken_[t] = 1;
        }
        return charts;
    }
    int split() const { return split_; }

  private:
    GrownChart chart_from(std::uint32_t seed) {
        GrownChart chart{mesh_.normal[seed], grow(seed, mesh_.normal[seed])};
        // Turns the plane to the mean of what it found, as long as it then finds more.
        double area = area_of(mesh_, chart.triangles);
        for (int round = 0; round < 4; ++round) {
            const glm::dvec3 mean = mean_normal(chart.triangles);
            if (!(glm::dot(mean, chart.normal) < 1 - 1e-9) || glm::dot(mean, mesh_.normal[seed]) < least_cosine_) break;
            GrownChart other{mean, grow(seed, mean)};
            if (!(area_of(mesh_, other.triangles) > area)) break;
            area = area_of(mesh_, other.triangles);
            chart = std::move(other);
        }
        // Two triangles that face the plane lie on either side of the edge between them.
        if (chart.triangles.size() <= 2) return chart;
        const Projection project(mesh_, seed, chart.normal);
        if (any_overlap(projected(project, chart.triangles), tolerance_)) {
            PlaneCover cover = cover_of(project, chart.triangles, tolerance_);
            cover.add(project(seed));
            chart.triangles = grow(seed, chart.normal, [&](std::uint32_t t) { return cover.add(project(t)); });
            ++split_;
        }
        return chart;
    }

    // What hangs together with the seed, faces n, and is in no chart; `accept` has the last word.
    template <class Accept>
    List grow(std::uint32_t seed, const glm::dvec3& n, const Accept& accept) {
        ++round_;
        List chart{seed};
        mark_[seed] = round_;
        for (std::size_t next = 0; next < chart.size(); ++next)
            for_neighbours(mesh_, chart[next], [&](std::uint32_t t, std::uint32_t) {
                if (mark_[t] == round_ || taken_[t] || !(glm::dot(mesh_.normal[t], n) >= least_cosine_)) return;
                if (!accept(t)) return;
                mark_[t] = round_;
                chart.push_back(t);
            });
        return chart;
    }
    List grow(std::uint32_t seed, const glm::dvec3& n) {
        return grow(seed, n, [](std::uint32_t) { return true; });
    }

    glm::dvec3 mean_normal(const List& chart) const {
        glm::dvec3 sum(0);
        for (std::uint32_t t : chart) sum += mesh_.normal[t] * mesh_.area[t];
        return unit(sum);
    }

    const SurfaceMesh& mesh_;
    const double least_cosine_, tolerance_;  // m
    List mark_;                              // [triangle]: the last growth that took it
    std::vector<char> taken_;                // [triangle]: in a chart
    std::uint32_t round_ = 0;
    int split_ = 0;
};

// Lets small charts join large ones.
class Joiner {
  public:
    Joiner(const SurfaceMesh& mesh, std::vector<GrownChart>& charts, double angle_deg, double tolerance)
        : mesh_(mesh),
          charts_(charts),
          least_cosine_(cosine(angle_deg)),
          tolerance_(tolerance),
          of_(mesh.count, 0),
          covers_(charts.size()) {
        for (std::uint32_t c = 0; c < charts.size(); ++c) {
            for (std::uint32_t t : charts[c].triangles) of_[t] = c;
            area_.push_back(area_of(mesh, charts[c].triangles));
        }
    }

    void join_all() {
        List order(charts_.size());
        std::iota(order.begin(), order.end(), 0u);
        std::sort(order.begin(), order.end(),
                  [&](std::uint32_t a, std::uint32_t b) { return area_[a] != area_[b] ? area_[a] < area_[b] : a < b; });
        for (std::uint32_t c : order)
            for (std::uint32_t other : neighbours(c))
                if (join(c, other)) break;
    }

  private:
    // Charts of four times the area, by the length of the common border, the longest first.
    List neighbours(std::uint32_t c) const {
        std::vector<std::pair<std::uint32_t, double>> borders;
        for (std::uint32_t t : charts_[c].triangles)
            for_neighbours(mesh_, t, [&](std::uint32_t u, std::uint32_t h) {
                if (of_[u] == c || !(area_[of_[u]] >= 4 * area_[c])) return;
                const glm::dvec3 edge =
                    glm::dvec3(mesh_.corner(next_half_edge(h)).position) - glm::dvec3(mesh_.corner(h).position);
                borders.push_back({of_[u], std::sqrt(glm::dot(edge, edge))});
            });
        std::stable_sort(borders.begin(), borders.end(),
                         [](const auto& a, const auto& b) { return a.first < b.first; });
        std::size_t count = 0;
        for (std::size_t i = 0; i < borders.size(); ++i)
            if (count > 0 && borders[count - 1].first == borders[i].first)
                borders[count - 1].second += borders[i].second;
            else
                borders[count++] = borders[i];
        borders.resize(count);
        std::stable_sort(borders.begin(), borders.end(),
                         [](const auto& a, const auto& b) { return a.second > b.second; });
        List charts;
        for (const auto& border : borders) charts.push_back(border.first);
        return charts;
    }

    bool join(std::uint32_t c, std::uint32_t other) {
        GrownChart &small = charts_[c], &large = charts_[other];
        for (std::uint32_t t : small.triangles)
            if (!(glm::dot(mesh_.normal[t], large.normal) >= least_cosine_)) return false;
        const Projection project(mesh_, large.triangles[0], large.normal);
        if (!covers_[other]) {
            covers_[other] = std::make_unique<PlaneCover>(cover_of(project, large.triangles, tolerance_));
            for (std::uint32_t t : large.triangles) covers_[other]->add_untested(project(t));
        }
        if (!covers_[other]->add(projected(project, small.triangles))) return false;
        for (std::uint32_t t : small.triangles) of_[t] = other;
        large.triangles.insert(large.triangles.end(), small.triangles.begin(), small.triangles.end());
        area_[other] += area_[c];
        small.triangles.clear();
        covers_[c].reset();
        return true;
    }

    const SurfaceMesh& mesh_;
    std::vector<GrownChart>& charts_;
    const double least_cosine_, tolerance_;
    List of_;                                          // [triangle]: chart
    std::vector<double> area_;                         // [chart]
    std::vector<std::unique_ptr<PlaneCover>> covers_;  // [chart]: where another one has wanted to join it
};

}  // namespace

void plane_axes(const glm::dvec3& n, glm::dvec3& first, glm::dvec3& second) {
    // Across the axis that n has least of.
    int least = 0;
    for (int c = 1; c < 3; ++c)
        if (std::fabs(n[c]) < std::fabs(n[least])) least = c;
    glm::dvec3 axis(0);
    axis[least] = 1;
    first = unit(glm::cross(axis, n));
    second = glm::cross(n, first);
}

PlanarCharts cut_into_charts(const SurfaceMesh& mesh, double angle_deg) {
    const double tolerance = overlap_tolerance(mesh);
    Grower grower(mesh, angle_deg * 5 / 6, tolerance);
    std::vector<GrownChart> grown = grower.grow_all();
    Joiner(mesh, grown, angle_deg, tolerance).join_all();
    PlanarCharts charts;
    charts.of.assign(mesh.count, -1);
    charts.split = grower.split();
    for (const GrownChart& chart : grown) {
        if (chart.triangles.empty()) continue;
        for (std::uint32_t t : chart.triangles) charts.of[t] = std::int32_t(charts.normal.size());
        charts.normal.push_back(chart.normal);
    }
    return charts;
}

}  // namespace plumb::probes
