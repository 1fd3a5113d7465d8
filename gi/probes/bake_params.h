// The parameters of a bake: the table [probes] of a scene file.
#pragma once

#include <vector>

#include "core/fields.h"
#include "core/ray_query.h"
#include "gi/probes/directions.h"
#include "gi/probes/placement.h"
#include "gi/probes/spatial_weight.h"

namespace plumb::probes {

// What rays that meet nothing bring: as Escape has it, or what suits the scene.
enum class Escapes : int { automatic, nothing, same_direction, visible_probes, all_probes, sky };
enum class Weighting : int { none, published };
enum class Gather : int { fitted, interpolated };

// fields() says what each means. Of the thesis' choices three are others: there a receiver has 10 probes and 512 rays, and probes are
// as many as a density of 0.02 / m3 asks for. More probes, fewer of them a receiver, and 128 rays have a third of the error for
// an eighth of the rays (README.md, What each number buys).
struct BakeParams {
    float receivers_per_m2 = 80;
    int lightmap_size = 0;
    int gap = 3;
    float chart_angle = 45;
    int test_rays = 64;
    float back_share = 0.5f;
    PlacementParams placement = {.least = 128, .overlaps = 3};
    int relight_rays = 512;
    int receiver_rays = 128;
    int degree = 7;
    Distribution distribution = Distribution::cosine;
    Escapes escapes = Escapes::automatic;
    Weighting weighting = Weighting::none;
    Gather gather = Gather::interpolated;
    int singular_values = 32;
    float threshold = 0.005f;
    int cluster_receivers = 1024;
    bool by_size_only = false;
    int spatial_receivers = 0;
    float spatial_back_share = 0.8f;
    SpatialWeight spatial_weight = SpatialWeight::corrected;
    Rays rays = Rays::exact;
};
std::vector<Field> fields(BakeParams& params);

// Throws InputError that names the parameter.
void validate(const BakeParams& params);

}  // namespace plumb::probes
