// Form factors by cosine-distributed rays, with what hides and with their standard error: the share of rays that meets
// a target. From a point or from all over a surface's front; to named targets, or to each triangle for a whole row.
//
// Rays come in batches, each stratified by a Sobol sequence with scrambles of its own (gi/reference/sampler_kernel.h),
// so that the batches' means are independent: standard error = sqrt(sum (m_b - mean)^2 / (B (B - 1))).
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "core/isa.h"
#include "core/ray_query.h"
#include "core/scene.h"
#include "gi/radiosity/contour.h"
#include "gi/radiosity/elements.h"

namespace plumb::radiosity {

struct RaySource {
    std::vector<Polygon> faces;  // empty: a point
    glm::dvec3 point{0}, normal{0};
    double area() const { return radiosity::area(faces); }
};

RaySource turned(const RaySource& from);  // the other side of its faces

struct RayFactorParams {
    std::int64_t rays = 1 << 18;  // at least `batches`; rounded up to a multiple of them
    int batches = 32;             // 2 to 4096
    std::uint32_t seed = 1;
};

struct RayFactor {
    double value = 0, standard_error = 0;
};

// targets[2 t] is what the front of triangle t counts for, targets[2 t + 1] its back: 0 to `count` - 1, or -1 for
// nothing. Returns a factor for each target. Counts are whole numbers: exact rays give the same bits for any number of
// threads. Throws InputError for parameters out of range.
std::vector<RayFactor> ray_form_factors(const RayQuery& query, const Geometry& geometry, const RaySource& from,
                                        const std::vector<std::int32_t>& targets, int count,
                                        const RayFactorParams& params, const RunOptions& options);

// Each triangle a target, whichever side is met: to hold against a hemicube's row.
std::vector<RayFactor> ray_form_factor_row(const RayQuery& query, const Geometry& geometry, const RaySource& from,
                                           const RayFactorParams& params, const RunOptions& options);

// Directions of one batch about +z, in an order in which those of a packet are neighbours: as good for any point as any other.
std::vector<glm::dvec3> cosine_directions(std::int64_t rays, std::uint32_t seed = 1);

// Adds to share[element] what element i sees of each, as a hemicube's row has it (rows.h): each ray that meets a front counts for its
// triangle's corners, by barycentrics. Backs, and what is met by none, count for nothing.
void add_ray_row(const RayQuery& query, const Elements& elements, int i, const std::vector<glm::dvec3>& directions, std::vector<double>& share);

// Points spread evenly over the faces, by area, each with its face's normal. Of a point: that point alone.
struct SourcePoint {
    glm::dvec3 position, normal;
};
std::vector<SourcePoint> source_points(const RaySource& from, int count, std::uint32_t seed = 1);

// How far rays, and hemicubes beside them, start off the surface, m: that of gi/reference.
double surface_offset(const Geometry& geometry);

// Whether a contour integral may be trusted: of segments between points of both that face each other, how many meet
// something, and how many triangles (of neither: occluders; of either: they hide parts of themselves) do so.
struct Between {
    int segments = 0, hidden = 0;
    int occluders = 0, own = 0;
};
// owner[t]: 0 of `from`, 1 of `to`, else of neither.
Between between(const RayQuery& query, const Geometry& geometry, const RaySource& from, const RaySource& to,
                const std::vector<std::int32_t>& owner, Sides sides, int segments, std::uint32_t seed = 1);

}  // namespace plumb::radiosity
