// What microfacets lose: directional albedos of the single reflection, tabulated once. README.md, "Microfacets".
#pragma once

#include "core/image.h"
#include "gi/reference/microfacet_layout.h"

namespace plumb::reference {

struct MicrofacetTables {
    Buffer<float> cells;  // [row][column][4]: S, T; S, T of the next column
    Buffer<float> rows;   // [row][4]: A, B; A, B of the next row
};

// Made by the first that asks, of arithmetic that has the same bits everywhere.
const MicrofacetTables& microfacet_tables();

// Directional albedos of the single reflection, D V cos over all directions: for a Fresnel factor of 1, and of Schlick's
// (1 - V.H)^5 alone. By quadrature: Gauss and Legendre's rule of `nodes` over the polar angle, in three pieces, the first in
// closed form over the azimuth, the second with `turns` midpoints of half of it.
struct Albedos {
    double single, schlick;
};
inline constexpr int table_nodes = 24, table_turns = 32;
Albedos albedos(double cosine, double alpha, int nodes = table_nodes, int turns = table_turns);

}  // namespace plumb::reference
