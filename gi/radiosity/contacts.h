// Where light leaks from one triangle to the next: T-junctions, contacts, and corners that nearly meet.
//
// Radiosity is interpolated over a triangle, whatever stands on it. Where a wall stands on the middle of a floor's triangle, its
// lit side's light is drawn on its dark side as well, as far as the triangle goes; where triangles meet along half an edge only,
// they disagree about the light there.
#pragma once

#include <cstdint>
#include <vector>

#include "core/scene.h"

namespace plumb::radiosity {

struct Contacts {
    double tolerance_m = 0;          // 2^-20 of the largest coordinate: what is nearer meets
    std::int64_t t_junctions = 0;    // positions of corners that lie inside of another triangle's edge
    std::int64_t nearly_equal = 0;   // positions that have another within the tolerance: edges there are not shared
    std::int64_t contacts = 0;       // edges that lie on faces of another object, and not along their edges
    std::vector<std::uint32_t> triangles;  // these faces, ascending
    std::vector<std::uint32_t> standing;   // the triangles whose edges they are, ascending
};

// Triangles without area are left out. An edge lies on a face where the points at 1/4 and 3/4 of it do: of an
// edge longer than the faces below it only those under these two are listed.
Contacts inspect_contacts(const Geometry& geometry);

}  // namespace plumb::radiosity
