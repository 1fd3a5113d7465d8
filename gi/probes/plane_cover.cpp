#include "gi/probes/plane_cover.h"

#include <algorithm>
#include <cmath>

namespace plumb::probes {

PlaneCover::PlaneCover(const glm::dvec2& low, const glm::dvec2& high, std::size_t expected, double tolerance)
    : low_(low), tolerance_(tolerance), pairs_left_((std::size_t(1) << 24) + 256 * expected) {
    const int side = std::clamp(int(std::sqrt(double(expected))), 1, 1024);
    const glm::dvec2 room = high - low;
    // Square cells, so that a long and narrow plane is not cut into needles.
    cell_ = std::max({room.x, room.y, 1e-300}) / side;
    columns_ = std::clamp(int(room.x / cell_) + 1, 1, side), rows_ = std::clamp(int(room.y / cell_) + 1, 1, side);
    cells_.resize(std::size_t(columns_) * std::size_t(rows_));
}

template <class Visit>
void PlaneCover::for_cells(const PlaneTriangle& t, const Visit& visit) {
    const PlaneBox own = bounds_of(t);
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
            if (pairs_left_ == 0 || (--pairs_left_, overlap(t, triangles_[other], tolerance_))) return free = false;
        return true;
    });
    if (free) add_untested(t);
    return free;
}

void PlaneCover::add_untested(const PlaneTriangle& t) {
    for_cells(t, [&](std::vector<std::uint32_t>& cell) {
        cell.push_back(std::uint32_t(triangles_.size()));
        return true;
    });
    triangles_.push_back(t);
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
