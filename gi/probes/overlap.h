// Whether triangles of a plane overlap: what decides if texture coordinates can serve a lightmap (IPR 3.2.1.1: "no mesh
// UV coordinates collide"), and if a projected chart folds over itself.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace plumb::probes {

using PlaneTriangle = std::array<glm::dvec2, 3>;

// Twice the signed area: positive where the corners turn from x towards y.
double twice_area(const PlaneTriangle& t);

// Whether a side of one triangle leaves the other one outside, but for `tolerance` in the plane's unit. Triangles that
// share a side or a corner, and lie beside each other, do not overlap. Both need an area; either may be mirrored.
bool overlap(const PlaneTriangle& a, const PlaneTriangle& b, double tolerance);

// Whether any two overlap. Exact but for the tolerance, by quartering the plane until few triangles share a cell;
// triangles without area are left out. Where more than 2^24 + 64 n pairs would have to be tested (fans of a thousand
// slivers), the answer is true without a proof: a lightmap that leaves them apart is always right.
bool any_overlap(const std::vector<PlaneTriangle>& triangles, double tolerance);

// Triangles added in groups, each only if none of it overlaps what is there.
class PlaneCover {
  public:
    // low, high: bounds of about all that will come; expected: about how many.
    PlaneCover(const glm::dvec2& low, const glm::dvec2& high, std::size_t expected, double tolerance);
    // False, and none added, where one of them overlaps another one or an earlier one.
    bool add(const std::vector<PlaneTriangle>& group);
    bool add(const PlaneTriangle& t);

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
};

}  // namespace plumb::probes
