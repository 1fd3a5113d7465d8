// Level of detail of the run time (IPR 4.2, 5.2.2): the table [lod] of a scene file, what it becomes for one scene and one bake,
// and what it leaves out. README.md, Level of detail, derives the rules.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/fields.h"
#include "core/isa.h"
#include "gi/probes/level.h"
#include "gi/probes/lod_air.h"
#include "gi/probes/stand_in.h"

namespace plumb::probes {

struct Bake;

// In which level a relight ray looks up the lightmap (IPR 4.2.1, two solutions).
enum class HitLevel : int {
    own,       // that of the place where it ends
    coarsest,  // the last one, which is always there
};
// From where the level of a probe is measured (IPR 4.2.1, figures 4.4 to 4.7).
enum class ProbeLevel : int {
    centre,    // its position
    radius,    // as published: its position, nearer by its radius
    clusters,  // as fine as the finest cluster that it supports, on surfaces or in the air: all that is read of it is computed
};

// fields() says what each means.
struct LodParams {
    int levels = 1;
    float distance_1 = -1, distance_2 = -1, distance_3 = -1;
    int degree_0 = -1, degree_1 = -1, degree_2 = -1, degree_3 = -1;
    int rays_0 = 0, rays_1 = 0, rays_2 = 0, rays_3 = 0;
    HitLevel hit_level = HitLevel::own;
    ProbeLevel probe_level = ProbeLevel::clusters;
    bool zones = false;
    float front_angle = 60, side_angle = 120;
    float side_scale = 2, behind_scale = 4;
    float smoothing = 0.25f;
    float fragment_shift = 0;
};
std::vector<Field> fields(LodParams& params);
// Throws InputError that names the parameter: one out of range, distances that do not ascend, degrees that do, rays that are no power
// of two.
void validate(const LodParams& params);

// What the parameters are for one scene and bake.
struct Lod {
    int levels = 1;
    std::array<int, most_levels> degree{}, coefficients{}, rays{};  // equal to the last level's beyond it
    HitLevel hit_level = HitLevel::own;
    ProbeLevel probe_level = ProbeLevel::clusters;
    LevelRule rule;                  // of boxes and hits; eye and forward are the view's
    glm::vec4 fragment_distances{0};  // xyz m: where fragments' levels 1, 2, 3 begin: at or before rule.distances
    std::vector<std::string> notes;   // what was taken otherwise than it was asked for, and what will show

    bool off() const { return levels == 1; }
};

// diagonal_m: of the scene's bounds. gap: texels between charts. Degrees above the bake's are cut. Throws InputError as validate() does,
// for more rays than the bake has, and for degrees that the rays' weights do not integrate.
Lod lod_of(const LodParams& params, double diagonal_m, int degree, int relight_rays, int gap);
Lod lod_of(const LodParams& params, const Bake& bake);

// For a view: forward need not be unit, but not 0.
LevelRule rule_at(const Lod& lod, const glm::vec3& eye, const glm::vec3& forward);
LevelRule fragment_rule_at(const Lod& lod, const glm::vec3& eye, const glm::vec3& forward);

// ---- What has a level ---------------------------------------------------------------------------------------------------

// A cluster is the box of its receivers; its margin is what a lookup in level 0 of the lightmap reaches on a surface: the fragment lies
// at most lookup_reach texels from each receiver that it reads, along both axes, twice as far in each coarser level.
inline constexpr int lookup_reach = 3;  // one texel by interpolation (lightmap_kernel.h), two by rings

struct LodBoxes {
    Buffer<glm::vec4> cluster_low, cluster_high;  // [clusters]: w m
    Buffer<glm::vec4> probe_low, probe_high;      // [probes]: w the radius
    Buffer<glm::vec4> hit;                        // [probes][rays]: where relight rays end, or what stands for them; else the probe
};
LodBoxes lod_boxes(const Bake& bake, Unasked unasked = Unasked::nearest);

struct Levels {
    std::vector<std::int32_t> cluster;  // [clusters]
    std::vector<std::int32_t> probe;    // [probes]
    std::vector<std::int32_t> hit;      // [probes][rays]: to look up the lightmap in; empty without levels of detail
    AirLevels air;                      // empty where nothing reads it, and without levels of detail
};
// reads: of the bake's grid in the air. Throws InputError for a view that has none.
Levels levels_at(const Lod& lod, const Bake& bake, const LodBoxes& boxes, const glm::vec3& eye, const glm::vec3& forward,
                 const RunOptions& options, const AirReads& reads = {});

// Whether a receiver is computed (IPR 4.2.3); its level is that of receiver_levels(), run_data.h.
constexpr bool is_computed(int receiver_level, int cluster_level) { return receiver_level >= cluster_level; }

// ---- What is left out ---------------------------------------------------------------------------------------------------

struct LodCounts {
    std::int64_t receivers = 0;                            // computed
    std::array<std::int64_t, most_levels> clusters{}, probes{};  // in each level
    std::int64_t rays = 0;                                 // relight rays that are summed
    std::int64_t lambda_terms = 0;                         // rays x coefficients, of all probes
    std::int64_t basis_terms = 0;                          // coefficients x rank, of all clusters' probes
    std::int64_t irradiance_terms = 0;                     // rank, of all computed receivers
    std::int64_t bytes = 0;                                // that the three read and write at least, in floats
};
LodCounts lod_counts(const Lod& lod, const Bake& bake, const Levels& levels);

// The same of the air, whose lambda are the surfaces': no probes, rays and lambda_terms.
LodCounts air_counts(const Lod& lod, const Bake& bake, const AirLevels& levels);

// Charts whose receivers are all missing in a level: what lies on them is 0 there.
std::array<int, most_levels> charts_missing(const Bake& bake, int levels);

}  // namespace plumb::probes
