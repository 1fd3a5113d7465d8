// Parts of buildings with round arches: columns, arcades, vaults, mouldings, curtains. For `atrium` and `hall`.
//
// Each part has its own space in metres, +Y up, its front towards +Z, and is cut the finer the larger `detail` is: 1 is
// what the scenes are meant to have.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "io/scenes/builder.h"

namespace plumb::io::scenes::parts {

// A material and how many metres its texture spans.
struct Surface {
    int material = 0;
    double size = 1;
};

// base * detail rounded, but not below `least`.
int cut(double detail, double base, int least);

// A column from y = 0 to `height`: square plinth, base of two tori, swelling shaft, capital with leaves, square abacus.
struct Column {
    double height = 3.55, radius = 0.3;
    double plinth = 0.42, abacus = 0.42;  // half widths
};
void column(Builder& b, const Surface& surface, const Place& place, const Column& column, double detail);

// A wall with a round arch that springs at y = 0: |x| <= half_width, y <= height, |z| <= thickness / 2. Both faces and
// the arch's underside; texture coordinates run on from one to the next where the widths are multiples of its size.
struct ArchWall {
    double half_width = 1.5, radius = 1.15, height = 2.3, thickness = 0.6;
};
void arch_wall(Builder& b, const Surface& surface, const Place& place, const ArchWall& wall, double detail);

// A profile of (outwards from `radius`, towards the viewer) around a half circle.
void arch_moulding(Builder& b, const Surface& surface, const Place& place, double radius, const Profile& profile,
                   double detail);

// The underside of two barrels of radius `half` that cross: |x| <= half, |z| <= half, springing at y = 0.
void groin_vault(Builder& b, const Surface& surface, const Place& place, double half, double detail);

// Cloth between x = -half_width and half_width from y = 0 down to -height, closed. drawn: in two halves that are tied
// back to the sides. cloth_detail: of its mesh.
struct Curtain {
    double half_width = 1.1, height = 3.2;
    bool drawn = false;
    std::uint32_t seed = 1;  // of the folds
};
void curtain(Builder& b, const Surface& surface, const Surface& metal, const Place& place, const Curtain& curtain,
             double cloth_detail);

// A baluster of that height, closed.
void baluster(Builder& b, const Surface& surface, const Place& place, double height, double radius, double detail);

// A door or a shuttered window at a wall z = 0: frame, lintel and two leaves of panels; its middle at x = 0.
void door(Builder& b, const Surface& frame, const Surface& leaf, const Surface& metal, const Place& place, double width,
          double height);

// A lantern that hangs from y = 0 on a chain; closed.
void lantern(Builder& b, const Surface& metal, const Surface& glass, const Place& place, double chain, double detail);

// An urn on a block, from y = 0 to 1.25 m, with leaves that hang over its rim.
void urn(Builder& b, const Surface& surface, const Surface& leaves, const Place& place, std::uint32_t seed,
         double detail);

// Leaves that hang in front of z = 0 from y = 0 down to -height; alpha gives their outline.
void hanging_leaves(Builder& b, const Surface& leaves, const Place& place, double width, double height,
                    std::uint32_t seed, double detail);

// A row of blocks under a cornice, from x = -length / 2 to length / 2, `spacing` apart.
void dentils(Builder& b, const Surface& surface, const Place& place, double length, double spacing, const Point& size);

}  // namespace plumb::io::scenes::parts
