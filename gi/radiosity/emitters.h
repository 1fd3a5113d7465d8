// Irradiance by small emitters: each triangle's form factor by its outline, times the share of it that rays find.
//
// A lamp of a few texels is seen by one row of them more or less from one element to the next, and a wall lit by it has bands. Small
// emitters are therefore taken out of what texels gather, as lamps of no size are; large ones stay there, where texels are good enough.
#pragma once

#include "core/isa.h"
#include "core/scene.h"
#include "gi/radiosity/elements.h"

namespace plumb::radiosity {

// By Elements::lamp_exitance, of each element, W/m2: sum over emitting triangles of M_t F_t V_t. F_t by Lambert's formula (contour.h), of the part of the triangle
// above the element's horizon, of its front alone. V_t by rays to places spread over it, each weighted by what it would bring; 64 in all
// to the emitters, shared out by power, and one at least to each triangle.
Buffer<glm::vec4> emitters_at(const Scene& scene, const Elements& elements, const RunOptions& options);

}  // namespace plumb::radiosity
