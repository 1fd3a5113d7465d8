#include "gi/probes/overlap.h"

#include <algorithm>
#include <cmath>

namespace plumb::probes {
namespace {

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

bool boxes_meet(const PlaneBox& a, const PlaneBox& b, double tolerance) {
    for (int c = 0; c < 2; ++c)
        if (a.low[c] >= b.high[c] - tolerance || b.low[c] >= a.high[c] - tolerance) return false;
    return true;
}

struct Boxes {
    const std::vector<PlaneTriangle>& triangles;
    double tolerance;
    std::size_t pairs_left;

    using List = std::vector<std::uint32_t>;

    bool pair(std::uint32_t a, std::uint32_t b) {
        return pairs_left-- == 0 || overlap(triangles[a], triangles[b], tolerance);
    }

    bool any_pair(const List& list) {
        if (list.size() > 64) return any_around_hub(list);
        for (std::size_t i = 0; i < list.size(); ++i)
            for (std::size_t j = i + 1; j < list.size(); ++j)
                if (pair(list[i], list[j])) return true;
        return false;
    }

    // Many triangles that no cell takes apart are a fan. Around the corner that most of them share, each of the fan
    // takes a sector; sorted by where sectors begin, one that overlaps any before it overlaps the one that reaches
    // farthest. Triangles that are not of the fan, or whose sector holds the direction of -x, are tested with all.
    bool any_around_hub(const List& list) {
        std::size_t count;
        const glm::dvec2 hub = most_common_corner(list, count);
        std::vector<Sector> fan;
        List others;
        for (std::uint32_t t : list) {
            Sector s;
            if (sector_at(hub, t, s))
                fan.push_back(s);
            else
                others.push_back(t);
        }
        for (std::size_t i = 0; i < others.size(); ++i) {
            for (std::size_t j = i + 1; j < others.size(); ++j)
                if (pair(others[i], others[j])) return true;
            for (const Sector& s : fan)
                if (pair(others[i], s.triangle)) return true;
        }
        std::sort(fan.begin(), fan.end(), [](const Sector& a, const Sector& b) {
            return a.from != b.from ? a.from < b.from : a.triangle < b.triangle;
        });
        std::size_t farthest = 0;
        for (std::size_t i = 1; i < fan.size(); ++i) {
            if (pair(fan[i].triangle, fan[i - 1].triangle) || pair(fan[i].triangle, fan[farthest].triangle))
                return true;
            if (fan[i].to > fan[farthest].to) farthest = i;
        }
        return false;
    }

    // Directions as numbers that rise with the angle from -x: -2..2.
    struct Sector {
        double from, to;
        std::uint32_t triangle;
    };
    static double direction(const glm::dvec2& d) {
        const double x = d.x / (std::fabs(d.x) + std::fabs(d.y));
        return d.y < 0 ? x - 1 : 1 - x;
    }
    bool sector_at(const glm::dvec2& hub, std::uint32_t t, Sector& s) const {
        for (std::size_t k = 0; k < 3; ++k) {
            if (triangles[t][k] != hub) continue;
            const glm::dvec2 a = triangles[t][(k + 1) % 3] - hub, b = triangles[t][(k + 2) % 3] - hub;
            const bool left = cross(a, b) > 0;
            s = {direction(left ? a : b), direction(left ? b : a), t};
            return s.from < s.to;
        }
        return false;
    }
    bool mostly_fan(const List& list) const {
        std::size_t count;
        most_common_corner(list, count);
        return 2 * count > list.size();
    }
    glm::dvec2 most_common_corner(const List& list, std::size_t& count) const {
        std::vector<glm::dvec2> corners;
        for (std::uint32_t t : list) corners.insert(corners.end(), triangles[t].begin(), triangles[t].end());
        std::sort(corners.begin(), corners.end(),
                  [](const glm::dvec2& a, const glm::dvec2& b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
        std::size_t best = 0;
        count = 0;
        for (std::size_t first = 0, i = 0; i < corners.size(); ++i) {
            if (corners[i] != corners[first]) first = i;
            if (i - first + 1 > count) count = i - first + 1, best = i;
        }
        return corners[best];
    }

    // Halves the box across its longer side, or across the other one where that cuts fewer triangles by a tenth.
    bool any(const List& list, const PlaneBox& box, int depth) {
        constexpr std::size_t few = 12;
        if (list.size() <= few || depth == 80) return any_pair(list);
        const int longer = box.high.x - box.low.x >= box.high.y - box.low.y ? 0 : 1;
        Halves best = halve(list, box, longer);
        if (10 * best.total() > 12 * list.size()) {
            Halves other = halve(list, box, 1 - longer);
            if (10 * other.total() < 9 * best.total()) best = std::move(other);
        }
        // Where most triangles lie in both halves, smaller boxes only repeat the same pairs; where they are the needles
        // of a fan, they do for long.
        if (4 * best.total() > 7 * list.size()) return any_pair(list);
        if (list.size() > 64 && 4 * best.total() > 5 * list.size() && mostly_fan(list)) return any_around_hub(list);
        for (int side = 0; side < 2; ++side)
            if (any(best.lists[side], best.boxes[side], depth + 1)) return true;
        return false;
    }

    struct Halves {
        PlaneBox boxes[2];
        List lists[2];
        std::size_t total() const { return lists[0].size() + lists[1].size(); }
    };
    Halves halve(const List& list, const PlaneBox& box, int axis) const {
        Halves h{{box, box}, {}};
        h.boxes[0].high[axis] = h.boxes[1].low[axis] = (box.low[axis] + box.high[axis]) * 0.5;
        for (int side = 0; side < 2; ++side)
            for (std::uint32_t t : list)
                if (reaches(triangles[t], h.boxes[side])) h.lists[side].push_back(t);
        return h;
    }
};

}  // namespace

double twice_area(const PlaneTriangle& t) { return cross(t[1] - t[0], t[2] - t[0]); }

PlaneBox bounds_of(const PlaneTriangle& t) {
    return {glm::min(t[0], glm::min(t[1], t[2])), glm::max(t[0], glm::max(t[1], t[2]))};
}

bool reaches(const PlaneTriangle& t, const PlaneBox& box) {
    const std::array<glm::dvec2, 4> corners{box.low, glm::dvec2(box.high.x, box.low.y), box.high,
                                            glm::dvec2(box.low.x, box.high.y)};
    const PlaneBox own = bounds_of(t);
    for (int c = 0; c < 2; ++c)
        if (own.low[c] > box.high[c] || box.low[c] > own.high[c]) return false;
    // The slack of the rounding of a cross product.
    const double size =
        std::max({std::fabs(own.low.x), std::fabs(own.low.y), std::fabs(own.high.x), std::fabs(own.high.y)});
    return !separates(t, corners, -0x1p-40 * size);
}

bool overlap(const PlaneTriangle& a, const PlaneTriangle& b, double tolerance) {
    return boxes_meet(bounds_of(a), bounds_of(b), tolerance) && !separates(a, b, tolerance) &&
           !separates(b, a, tolerance);
}

bool any_overlap(const std::vector<PlaneTriangle>& triangles, double tolerance) {
    Boxes::List list;
    PlaneBox box{glm::dvec2(HUGE_VAL), glm::dvec2(-HUGE_VAL)};
    double area = 0;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        if (twice_area(triangles[i]) == 0) continue;
        const PlaneBox own = bounds_of(triangles[i]);
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
    return Boxes{triangles, tolerance, (std::size_t(1) << 24) + 64 * list.size()}.any(list, box, 0);
}

}  // namespace plumb::probes
