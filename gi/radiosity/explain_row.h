// One row of form factors, texel by texel: what an element's hemicube sees, what each texel weighs, and what it brings.
#pragma once

#include <vector>

#include "core/image.h"
#include "core/tap.h"
#include "gi/radiosity/rows.h"

namespace plumb::radiosity {

// A hemicube unfolded: the top in the middle, a side at each of its edges, its own edge towards the top; outside of them -1 or 0.
//
//         .  u  .       up: u, right: -t
//         t top -t
//         . -u  .
struct RowPictures {
    Image<std::int32_t> triangle;  // that the texel sees; -1: none
    Image4 weight;                 // x: share of the hemisphere, weighted by cosine; y: 1 where a front is seen, -1 a back, 0 nothing
    Image4 radiosity;              // W/m2, of what is seen; 0 for backs
    Image4 brought;                // W/m2: weight times radiosity
};

struct RowExplained {
    std::vector<TapValue> values;  // samples are elements, those that bring most
    RowPictures pictures;
};

inline constexpr int explained_elements = 32;

// own: H_0 of all elements, radiosity: B, W/m2. The last value, "irradiance", is H of the packed row in double precision; before it the
// same from texels, whose weights were not yet packed into halves.
RowExplained explain_row(const Elements& elements, const RowParams& params, const FormFactors& factors, const Buffer<glm::vec4>& own,
                         const Buffer<glm::vec4>& radiosity, int element);

}  // namespace plumb::radiosity
