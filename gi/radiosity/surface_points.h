// Where points lie on a surface: found by a tree, held against a triangle within a tolerance.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "gi/probes/surface_mesh.h"

namespace plumb::radiosity {

using Point = glm::dvec3;

inline double length(const Point& v) { return std::sqrt(glm::dot(v, v)); }

// What is nearer meets: 2^-20 of the largest coordinate, m.
inline double meeting_distance(const probes::SurfaceMesh& mesh) {
    float extent = 0;
    for (std::uint32_t h : mesh.half_edges)
        for (int c = 0; c < 3; ++c) extent = std::max(extent, std::fabs(mesh.corner(h).position[c]));
    return double(extent) * 0x1p-20;
}

struct Box {
    Point low, high;
    Box(const Point& a, const Point& b, double pad) : low(glm::min(a, b) - pad), high(glm::max(a, b) + pad) {}
    Box(const Point& a, const Point& b, const Point& c, double pad)
        : low(glm::min(a, glm::min(b, c)) - pad), high(glm::max(a, glm::max(b, c)) + pad) {}
    bool holds(const Point& p) const {
        return p.x >= low.x && p.y >= low.y && p.z >= low.z && p.x <= high.x && p.y <= high.y && p.z <= high.z;
    }
    bool touches(const Box& b) const {
        return b.high.x >= low.x && b.high.y >= low.y && b.high.z >= low.z && b.low.x <= high.x && b.low.y <= high.y && b.low.z <= high.z;
    }
};

// Points by halves along x, y and z in turn. What a query finds does not depend on how ties were sorted, its order does.
class PointTree {
  public:
    explicit PointTree(std::vector<Point> points) : points_(std::move(points)), order_(points_.size()) {
        for (std::uint32_t i = 0; i < order_.size(); ++i) order_[i] = i;
        sort(0, order_.size(), 0);
    }
    const Point& operator[](std::uint32_t i) const { return points_[i]; }
    template <class F>
    void query(const Box& box, const F& f) const {
        visit(box, 0, order_.size(), 0, f);
    }

  private:
    void sort(std::size_t first, std::size_t last, int axis) {
        if (last - first < 2) return;
        const std::size_t middle = first + (last - first) / 2;
        std::nth_element(order_.begin() + long(first), order_.begin() + long(middle), order_.begin() + long(last),
                         [&](std::uint32_t a, std::uint32_t b) { return points_[a][axis] < points_[b][axis]; });
        sort(first, middle, (axis + 1) % 3);
        sort(middle + 1, last, (axis + 1) % 3);
    }
    template <class F>
    void visit(const Box& box, std::size_t first, std::size_t last, int axis, const F& f) const {
        if (first >= last) return;
        const std::size_t middle = first + (last - first) / 2;
        const Point& p = points_[order_[middle]];
        if (box.holds(p)) f(order_[middle]);
        if (box.low[axis] <= p[axis]) visit(box, first, middle, (axis + 1) % 3, f);
        if (box.high[axis] >= p[axis]) visit(box, middle + 1, last, (axis + 1) % 3, f);
    }

    std::vector<Point> points_;
    std::vector<std::uint32_t> order_;
};

// Boxes by halves of their middles along x, y and z in turn, each half with its bounds: what touches a box is found in its own time,
// however large others are. Its order depends on how ties were sorted.
class BoxTree {
  public:
    explicit BoxTree(std::vector<Box> boxes) : boxes_(std::move(boxes)), order_(boxes_.size()), bounds_(boxes_) {
        for (std::uint32_t i = 0; i < order_.size(); ++i) order_[i] = i;
        sort(0, order_.size(), 0);
    }
    template <class F>
    void query(const Box& box, const F& f) const {
        visit(box, 0, order_.size(), f);
    }

  private:
    // bounds_[middle]: of all between first and last.
    void sort(std::size_t first, std::size_t last, int axis) {
        if (first >= last) return;
        const std::size_t middle = first + (last - first) / 2;
        std::nth_element(order_.begin() + long(first), order_.begin() + long(middle), order_.begin() + long(last), [&](std::uint32_t a, std::uint32_t b) {
            return boxes_[a].low[axis] + boxes_[a].high[axis] < boxes_[b].low[axis] + boxes_[b].high[axis];
        });
        Box& all = bounds_[middle] = boxes_[order_[middle]];
        const auto take = [&](std::size_t from, std::size_t to) {
            if (from >= to) return;
            sort(from, to, (axis + 1) % 3);
            const Box& half = bounds_[from + (to - from) / 2];
            all.low = glm::min(all.low, half.low), all.high = glm::max(all.high, half.high);
        };
        take(first, middle), take(middle + 1, last);
    }
    template <class F>
    void visit(const Box& box, std::size_t first, std::size_t last, const F& f) const {
        if (first >= last) return;
        const std::size_t middle = first + (last - first) / 2;
        if (!box.touches(bounds_[middle])) return;
        if (box.touches(boxes_[order_[middle]])) f(order_[middle]);
        visit(box, first, middle, f), visit(box, middle + 1, last, f);
    }

    std::vector<Box> boxes_;
    std::vector<std::uint32_t> order_;
    std::vector<Box> bounds_;
};

enum Where { off_it, at_border, within };

// Of p to the triangle, with so much tolerance.
inline Where where_on(const probes::SurfaceMesh& m, std::size_t t, const Point& p, double tolerance) {
    const Point& n = m.normal[t];
    if (std::fabs(glm::dot(p - m.position(t, 0), n)) > tolerance) return off_it;
    Where where = within;
    for (int k = 0; k < 3; ++k) {
        const Point a = m.position(t, k), along = m.position(t, (k + 1) % 3) - a;
        const double inwards = glm::dot(glm::cross(n, along), p - a) / length(along);
        if (inwards < -tolerance) return off_it;
        if (inwards <= tolerance) where = at_border;
    }
    return where;
}

}  // namespace plumb::radiosity
