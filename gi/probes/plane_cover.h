// Triangles of a plane that do not overlap, one added after the other: how a chart grows that would cover itself.
#pragma once

#include <vector>

#include "gi/probes/overlap.h"

namespace plumb::probes {

// Triangles added in groups, each only if none of it overlaps what is there. After 2^24 + 256 n pairs were tested, none
// is taken any more.
class PlaneCover {
  public:
    // low, high: bounds of about all that will come; expected: about how many.
    PlaneCover(const glm::dvec2& low, const glm::dvec2& high, std::size_t expected, double tolerance);
    // False, and none added, where one of them overlaps another one or an earlier one.
    bool add(const std::vector<PlaneTriangle>& group);
    bool add(const PlaneTriangle& t);
    void add_untested(const PlaneTriangle& t);  // known to overlap none

  private:
    void remove_last();
    // Calls visit(cell) for those that the triangle may touch, until it says false.
    template <class Visit>
    void for_cells(const PlaneTriangle& t, const Visit& visit);

    std::vector<PlaneTriangle> triangles_;
    std::vector<std::vector<std::uint32_t>> cells_;  // [row][column]: what touches the cell
    glm::dvec2 low_;
    double cell_;
    int columns_, rows_;
    double tolerance_;
    std::size_t pairs_left_;
};

}  // namespace plumb::probes
