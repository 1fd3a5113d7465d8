// The integral over two straight edges of d_p . d_q ln r: what a contour integral is made of.
#pragma once

#include <glm/glm.hpp>

namespace plumb::radiosity {

struct Edge {
    glm::dvec3 from, to;
};

struct EdgeIntegral {
    double value = 0, error = 0;  // of the quadrature, absolute
    double magnitude = 0;         // of the terms that were summed: what rounding is measured by
};

// Lengths are to be about 1. `tolerance`: absolute.
EdgeIntegral edge_integral(const Edge& p, const Edge& q, double tolerance);

}  // namespace plumb::radiosity
