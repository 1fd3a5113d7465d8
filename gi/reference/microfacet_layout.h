// How microfacet_tables.h lays its tables out, and for which surfaces: for the kernel, which sees no container.
#pragma once

namespace plumb::reference {

// Smoother surfaces are taken as of this alpha: half of their light leaves within 0.01 degrees of the mirrored direction.
inline constexpr float least_alpha = 1e-4f;
inline constexpr float dielectric_f0 = 0.04f;

// Rows are even in the fourth root of alpha, from least_alpha's to 1; columns in that of the cosine, from 0 to 1. Linear
// in between.
inline constexpr int microfacet_rows = 64, microfacet_columns = 96;
inline constexpr float first_row_root = 0.1f;  // least_alpha^(1/4)

// E: albedo of the single reflection where Fresnel's factor is 1. E_d: of all that a dielectric's surface reflects, what
// meets several facets included. avg: the cosine-weighted means. Then 1 - E = S A and 1 - E_d = T B with
//     S = alpha (1 - E)/sqrt(pi (1 - E_avg)),  A = sqrt(pi (1 - E_avg))/alpha,
//     T = (1 - E_d)/sqrt(pi (1 - E_d,avg)),    B = sqrt(pi (1 - E_d,avg)).

}  // namespace plumb::reference
