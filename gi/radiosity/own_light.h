// H0 of elements but for lamps: what the sky and small emitters send, before any of it is reflected.
#pragma once

#include "gi/radiosity/radiosity_params.h"

namespace plumb::radiosity {

// Of each element, W/m2. A sky of one colour by the share of the row that sees nothing; of a map each such texel brings the
// radiance in the direction of its middle. Small emitters as emitters.h has them;
// by_emitters, where it is asked for: their part.
Buffer<glm::vec4> own_light(const Scene& scene, const Elements& elements, const FormFactors& factors, const RadiosityParams& params,
                            const RunOptions& options, Buffer<glm::vec4>* by_emitters = nullptr);

}  // namespace plumb::radiosity
