// Point sets and mappings, in double precision: tables that a stage gets as an input, never computed in a kernel.
//
// A sequence is progressive where every prefix is as uniform as its length allows; a set is made for one length.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace plumb {

// ---- Points in [0, 1) and [0, 1)^2 --------------------------------------------------------------------------------

// The digits of i in `base`, mirrored at the point (van der Corput 1935): 1 = 1, 2 = 10, 3 = 11 become 1/2, 1/4, 3/4.
double van_der_corput(std::uint64_t i, std::uint32_t base = 2);
// Bases 2 and 3 (Halton 1960). Progressive.
glm::dvec2 halton(std::uint64_t i);
// (i + 1/2) / n and base 2: a set of n points.
glm::dvec2 hammersley(std::uint64_t i, std::uint64_t n);
// Multiples of (1/g, 1/g^2) modulo 1, g^3 = g + 1, from (1/2, 1/2) (Roberts 2018, "The Unreasonable Effectiveness of
// Quasirandom Sequences"): the golden ratio's recurrence in two dimensions. Progressive.
glm::dvec2 r2(std::uint64_t i);
// The first two dimensions of Sobol's sequence (1967), a (0, 2)-sequence: every aligned run of 2^m points puts one into
// each dyadic box of area 2^-m. Progressive. i < 2^32.
glm::dvec2 sobol(std::uint32_t i);

// n points of the unit square, wrapped around at its edges, each the farthest of `candidates` * (points so far) hashed
// candidates from those before (Mitchell 1991, "Spectrally Optimal Sampling for Distribution Ray Tracing").
// Progressive; the same for the same seed everywhere.
std::vector<glm::dvec2> best_candidates(int n, std::uint32_t seed, int candidates = 4);

// ---- From the unit square to discs, hemispheres and the sphere ----------------------------------------------------
//
// sample maps u in [0, 1)^2; pdf is the density of its image per unit of area or per steradian, 0 outside; inverse maps
// back. Directions have z as their pole.

// The unit disc by radius sqrt(u.x) and angle 2 pi u.y.
glm::dvec2 sample_disc(const glm::dvec2& u);
double pdf_disc(const glm::dvec2& p);
glm::dvec2 inverse_disc(const glm::dvec2& p);

// The unit disc by concentric squares, which stretches least (Shirley and Chiu 1997).
glm::dvec2 sample_disc_concentric(const glm::dvec2& u);
glm::dvec2 inverse_disc_concentric(const glm::dvec2& p);

// The published disc of RSM gathers: radius u.x, so the density falls with the radius. LRA 4.3.3 swaps sine and cosine.
glm::dvec2 sample_disc_linear(const glm::dvec2& u);
double pdf_disc_linear(const glm::dvec2& p);
glm::dvec2 inverse_disc_linear(const glm::dvec2& p);

glm::dvec3 sample_sphere(const glm::dvec2& u);
double pdf_sphere();
glm::dvec2 inverse_sphere(const glm::dvec3& d);

glm::dvec3 sample_hemisphere(const glm::dvec2& u);
double pdf_hemisphere(const glm::dvec3& d);
glm::dvec2 inverse_hemisphere(const glm::dvec3& d);

// Density cos(theta) / pi.
glm::dvec3 sample_cosine_hemisphere(const glm::dvec2& u);
double pdf_cosine_hemisphere(const glm::dvec3& d);
glm::dvec2 inverse_cosine_hemisphere(const glm::dvec3& d);

// The lobe cos(theta)^exponent of Phong's model, density (exponent + 1) / (2 pi) cos(theta)^exponent.
glm::dvec3 sample_cosine_power(const glm::dvec2& u, double exponent);
double pdf_cosine_power(const glm::dvec3& d, double exponent);
glm::dvec2 inverse_cosine_power(const glm::dvec3& d, double exponent);

// Directions within a cone of half angle theta, cos_theta = cos(theta): uniform, density 1 / (2 pi (1 - cos_theta)).
glm::dvec3 sample_cone(const glm::dvec2& u, double cos_theta);
double pdf_cone(const glm::dvec3& d, double cos_theta);
glm::dvec2 inverse_cone(const glm::dvec3& d, double cos_theta);

// ---- Measures -----------------------------------------------------------------------------------------------------

// Star discrepancy of points in [0, 1]^2: the largest difference between the share of points in a box [0, a) x [0, b)
// and its area. Exact, in O(n^2 log n).
double star_discrepancy(const std::vector<glm::dvec2>& points);

}  // namespace plumb
