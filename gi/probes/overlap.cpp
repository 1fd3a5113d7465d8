#include "gi/probes/overlap.h"

#include <algorithm>
#include <cmath>

namespace plumb::probes {
namespace {

struct Box {
    glm::dvec2 low, high;
};

Box box_of(const PlaneTriangle& t) {
    return {glm::min(t[0], glm::min(t[1], t[2])), glm::max(t[0], glm::max(t[1], t[2]))};
}

double cross(const glm::dvec2& a, const glm::dvec2& b) { return a.x * b.y - a.y * b.x; }

// Whether a side of `a` has all n points on its outer side, or at most `tolerance` inside.
template <std::size_t n>
bool separates(const PlaneTriangle& a, const std::array<glm::dvec2, n>& points, double tolerance) {
    const double turn = twice_area(a) < 0 ? -1 : 1;
    for (std::size_t i = 0; i < 3; ++i) {
        const glm::dvec2 side = a[(i + 1) % 3] - a[i];
        const double limit = tolerance * std::sqrt(side.x * side.x + side.y * side.y);
        double deepest = -HUGE_VAL;
        for (const glm::dvec2& p : points) deepest = std::max(deepest, turn * cross(side, p - a[i]));
        if (deepest <= limit) return true;
    }
    return false;
}

bool boxes_meet(const Box& a, const Box& b, double tolerance) {
    for (int c = 0; c < 2; ++c)
        if (a.low[c] >= b.high[c] - tolerance || b.low[c] >= a.high[c] - tolerance) return false;
    return true;
}

// Whether the triangle may reach into the box: never a wrong no.
bool reaches(const PlaneTriangle& t, const Box& box) {
    const std::array<glm::dvec2, 4> corners{box.low, glm::dvec2(box.high.x, box.low.y), box.high,
                                            glm::dvec2(box.low.x, box.high.y)};
    const Box own = box_of(t);
    for (int c = 0; c < 2; ++c)
        if (own.low[c] > box.high[c] || box.low[c] > own.high[c]) return false;
    // The slack of the rounding of a cross product.
    const double size = std::max({std::fabs(own.low.x), std::fabs(own.low.y), std::fabs(own.high.x), std::fabs(own.high.y)});
    return !separates(t, corners, -0x1p-40 * size);
}

struct Quarters {
    const std::vector<PlaneTriangle>& triangles;
    double tolerance;
    std::size_t pairs_left;

    using List = std::vector<std::uint32_t>;

    bool any_pair(const List& list) {
        for (std::size_t i = 0; i < list.size(); ++i)
            for (std::size_t j = i + 1; j < list.size(); ++j) {
                if (pairs_left-- == 0) return true;
                if (overlap(triangles[list[i]], triangles[list[j]], tolerance)) return true;
            }
        return false;
    }

    bool any(const List& list, const Box& box, int depth) {
        constexpr std::size_t few = 12;
        if (list.size() <= few || depth == 40) return any_pair(list);
        const glm::dvec2 middle = (box.low + box.high) * 0.5;
        Box parts[4];
        List lists[4];
        std::size_t total = 0;
        for (int q = 0; q < 4; ++q) {
            parts[q] = box;
            (q & 1 ? parts[q].low : parts[q].high).x = middle.x;
            (q & 2 ? parts[q].low : parts[q].high).y = middle.y;
            for (std::uint32_t t : list)
                if (reaches(triangles[t], parts[q])) lists[q].push_back(t);
            total += lists[q].size();
        }
        // Where most triangles lie in most quarters, smaller cells only repeat the same pairs.
        if (total > 3 * list.size()) return any_pair(list);
        for (int q = 0; q < 4; ++q)
            if (any(lists[q], parts[q], depth + 1)) return true;
        return false;
    }
};

}  // namespace

double twice_area(const PlaneTriangle& t) { return cross(t[1] - t[0], t[2] - t[0]); }

bool overlap(const PlaneTriangle& a, const PlaneTriangle& b, double tolerance) {
    return boxes_meet(box_of(a), box_of(b), tolerance) && !separates(a, b, tolerance) && !separates(b, a, tolerance);
}

bool any_overlap(const std::vector<PlaneTriangle>& triangles, double tolerance) {
    Quarters::List list;
    Box box{glm::dvec2(HUGE_VAL), glm::dvec2(-HUGE_VAL)};
    double area = 0;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        if (twice_area(triangles[i]) == 0) continue;
        const Box own = box_of(triangles[i]);
        box = {glm::min(box.low, own.low), glm::max(box.high, own.high)};
        area += std::fabs(twice_area(triangles[i])) / 2;
        list.push_back(std::uint32_t(i));
    }
    if (list.size() < 2) return false;
    // More area than there is room for overlaps somewhere, deeper than tolerance if by more than what a rim of that
    // width around each triangle holds.
    const glm::dvec2 room = box.high - box.low;
    const double rims = 4 * tolerance * (room.x + room.y) * double(list.size());
    if (area > room.x * room.y * (1 + 0x1p-30) + rims) return true;
    return Quarters{triangles, tolerance, (std::size_t(1) << 24) + 64 * list.size()}.any(list, box, 0);
}

PlaneCover::PlaneCover(const glm::dvec2& low, const glm::dvec2& high, std::size_t expected, double tolerance)
    : low_(low), tolerance_(tolerance) {
    const int side = std::clamp(int(std::sqrt(double(expected))), 1, 1024);
    const glm::dvec2 room = high - low;
    // Square cells, so that a long and narrow plane is not cut into needles.
    cell_ = std::max({room.x, room.y, 1e-300}) / side;
    columns_ = std::clamp(int(room.x / cell_) + 1, 1, side), rows_ = std::clamp(int(room.y / cell_) + 1, 1, side);
    cells_.resize(std::size_t(columns_) * std::size_t(rows_));
}

template <class Visit>
void PlaneCover::for_cells(const PlaneTriangle& t, const Visit& visit) {
    const Box own = box_of(t);
    auto at = [](double x, double low, double cell, int count) {
        return int(std::clamp((x - low) / cell, 0.0, double(count - 1)));
    };
    const int x0 = at(own.low.x, low_.x, cell_, columns_), x1 = at(own.high.x, low_.x, cell_, columns_);
    const int y0 = at(own.low.y, low_.y, cell_, rows_), y1 = at(own.high.y, low_.y, cell_, rows_);
    for (int y = y0; y <= y1; ++y)
        for (int x = x0; x <= x1; ++x) {
            // Cells at the rim hold what lies beyond it, too.
            const bool rim = x == 0 || y == 0 || x == columns_ - 1 || y == rows_ - 1;
            const glm::dvec2 corner = low_ + glm::dvec2(x, y) * cell_;
            if (!rim && !reaches(t, {corner, corner + cell_})) continue;
            if (!visit(cells_[std::size_t(y) * std::size_t(columns_) + std::size_t(x)])) return;
        }
}

bool PlaneCover::add(const PlaneTriangle& t) {
    bool free = true;
    for_cells(t, [&](const std::vector<std::uint32_t>& cell) {
        for (std::uint32_t other : cell)
            if (overlap(t, triangles_[other], tolerance_)) return free = false;
        return true;
    });
    if (!free) return false;
    for_cells(t, [&](std::vector<std::uint32_t>& cell) {
        cell.push_back(std::uint32_t(triangles_.size()));
        return true;
    });
    triangles_.push_back(t);
    return true;
}

void PlaneCover::remove_last() {
    const PlaneTriangle t = triangles_.back();
    for_cells(t, [](std::vector<std::uint32_t>& cell) {
        cell.pop_back();
        return true;
    });
    triangles_.pop_back();
}

bool PlaneCover::add(const std::vector<PlaneTriangle>& group) {
    const std::size_t before = triangles_.size();
    for (const PlaneTriangle& t : group)
        if (!add(t)) {
            while (triangles_.size() > before) remove_last();
            return false;
        }
    return true;
}

}  // namespace plumb::probes
