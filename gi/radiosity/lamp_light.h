// Irradiance of elements by lamps: its mean around each, not its value at the point where the element stands.
//
// The edge of a lamp's shadow, or of its cone, runs between elements: by values at points a floor that is half lit reflects too much or
// too little, as it happens. The picture takes lamps' light from shadow maps; here only what is reflected of it counts.
#pragma once

#include "core/isa.h"
#include "core/scene.h"
#include "gi/radiosity/elements.h"

namespace plumb::radiosity {

// W/m2: H_i = integral of phi_i H / integral of phi_i, phi_i as elements.h interpolates (an element's area is its integral), by 16 places
// on each triangle, with shadows by rays. So sum A_i H_i is the power that arrives, whatever the mesh.
Buffer<glm::vec4> lamps_on(const Scene& scene, const Elements& elements, const RunOptions& options);

}  // namespace plumb::radiosity
