// Where irradiance probes stand, and how far they reach (IPR 3.2.2, figures 3.12 to 3.14). See README.md.
#pragma once

#include <vector>

#include "core/fields.h"
#include "core/image.h"
#include "core/isa.h"
#include "core/ray_query.h"
#include "core/scene.h"

namespace plumb::probes {

enum class RadiusOf : int { covering, mean, largest };

// fields() says what each means.
struct PlacementParams {
    float probes_per_m3 = 0.02f;
    int count = 0;
    int least = 8;
    bool both_sides = true;
    bool beyond_bounds = false;
    int candidates_per_probe = 8;
    int overlaps = 10;
    int sample_receivers = 4096;
    RadiusOf radius_of = RadiusOf::covering;
};
std::vector<Field> fields(PlacementParams& params);
inline constexpr int most_wanted = 1 << 18;

struct Placement {
    Buffer<glm::vec4> candidates;  // xyz m; w: density K_i before any was removed
    Buffer<glm::vec4> probes;      // xyz m; w 0; in the order of the candidates; a bake may add the sky (sky_probe.h)
    std::vector<std::int32_t> candidate;  // of each probe; -1: the sky
    int wanted = 0;                // the number that count, or density and bounds, ask for
    double rho_m = 0;              // edge of the cubes of which `wanted` cover the bounds
    double cell_m = 0;             // edge of a voxel
    double kernel_radius_m = 0;    // of the density, when the last probe was removed: rho_m times a power of two
    int halvings = 0;              // of the cell, from rho_m / 2, until there were enough candidates
    // Voxels that hold no candidate, and why:
    std::int64_t in_surface = 0;     // a surface is in it (rule 1)
    std::int64_t beyond = 0;         // beside the scene's bounds, not within
    std::int64_t behind = 0;         // beside surfaces, behind all of them (figure 3.13)
    std::int64_t without_normal = 0; // beside a surface without normal; 0 with both_sides
    std::int64_t inside = 0;         // of the rays from it that hit something, 60 % or more hit back faces (rule 3)
};

// How many probes the bounds are worth: the product over the axes of size / rho_p, at least 1 each, rho_p =
// probes_per_m3^(-1/3); at least `least`; or `count`. Throws InputError for numbers out of range, or above most_wanted.
int wanted_probes(const glm::dvec3& size_m, const PlacementParams& params);

// Voxel candidates beside surfaces, thinned to wanted_probes(). `rays` are those of the geometry. The same bits for any
// number of threads and every instruction set if the rays are exact. Throws InputError where the geometry is empty or not
// finite, where `count` asks for more than there are places, and where there is no place at all.
Placement place_probes(const Geometry& geometry, const RayQuery& rays, const PlacementParams& params,
                       const RunOptions& options);

// The one radius of all probes (IPR 3.2.2.2): r_i is a receiver's distance to its overlaps-th nearest probe, or to the
// farthest where there are fewer.
struct ProbeRadius {
    double radius_m = 0;   // as `radius_of` asks
    double mean_m = 0;     // of r_i over the sample, as published: about half of the receivers have fewer probes
    double covering_m = 0; // the mean, or 17/16 of the largest distance of a receiver to its nearest probe: each has one
    double largest_m = 0;  // 17/16 of the largest r_i over all receivers: each has its probes, none at weight 0
    int sampled = 0;       // receivers of the mean: every k-th, k the least that gives sample_receivers or fewer
};
// receivers, probes: xyz m. Throws InputError for an empty list and positions that are not finite.
ProbeRadius probe_radius(const Buffer<glm::vec4>& probes, const Buffer<glm::vec4>& receivers,
                         const PlacementParams& params, const RunOptions& options);

}  // namespace plumb::probes
