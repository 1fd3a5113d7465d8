// What each number of a bake of irradiance probes buys: its irradiance against one that knows neither probes nor harmonics nor
// clusters (gi/probes/README.md, "What each number buys").
//
// Between that truth and what the run time shows lie steps, each with one approximation more than the one before:
//
//     truth        mean over many rays of the radiance that comes back along each, times pi
//     rays         the same over the rays that the bake has
//     unseen       over those whose end some supporting probe sees
//     degree       that radiance as the probes' harmonics have it; their coefficients by many relight rays
//     relight      their coefficients by the bake's relight rays
//     truncation   the transport as its clusters have it
//     rounding     transport, matrices and coefficients stored and summed in float
//
// All but the last are in double; the steps' differences add up to the whole error. The radiance that leaves a surface is given
// (direct light with shadow rays) and the same for all.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <vector>

#include "gi/probes/bake.h"
#include "raster/surfaces.h"

namespace plumb::cli {

// ---- Light ------------------------------------------------------------------------------------------------------------

// Where a ray ended.
struct RayEnd {
    bool found = false, front = false;
    std::int32_t triangle = 0;
    glm::vec2 barycentrics{0};
    glm::vec3 position{0}, direction{0};  // m, world; unit, of the ray
};
// Luminance that comes back along the ray, W/(m2 sr). Called by several threads at once.
using Radiance = std::function<double(const RayEnd&)>;

// What rays are traced against. A bake's atlas has the same triangles in the same order.
struct LadderWorld {
    LadderWorld(const Scene& scene, Rays rays);
    LadderWorld(const LadderWorld&) = delete;

    const Scene& scene;
    Geometry geometry;
    raster::Surfaces surfaces;
    std::unique_ptr<RayQuery> query;
    float offset;  // m, off surfaces

    raster::SurfaceArgs args() const { return raster::surface_args(geometry, surfaces, View{}); }
};

// (emission + albedo x irradiance by lamps with a shadow ray each) / pi on fronts, 0 on backs, the sky's where nothing is met.
// The world must outlive it.
Radiance direct_light(const LadderWorld& world);

// ---- Truth ------------------------------------------------------------------------------------------------------------

// Receivers that are held against the truth.
struct CheckedReceivers {
    probes::Receivers receivers;
    std::vector<int> index;           // of each among all receivers of its bake
    std::vector<double> truth;        // W/m2
    std::vector<double> uncertainty;  // W/m2: half of what two halves of the rays differ by
    int rays = 0;                     // of the bake's kind that have a radiance
    std::vector<float> radiance;      // [receiver][rays]
    Buffer<glm::vec4> directions;     // of these rays
    int before_sky = 0;               // receivers that were left out because they see too much of it

    int count() const { return int(index.size()); }
    double mean() const;                  // of the truth
    double relative_uncertainty() const;  // local_rms()
};
// Irradiance of the receivers by the first n directions, for each n of `prefixes`, the set turned about each normal:
// [prefix][receiver].
std::vector<std::vector<double>> irradiance_by(const LadderWorld& world, const Radiance& radiance,
                                               const probes::Receivers& receivers, const Buffer<glm::vec4>& directions,
                                               const std::vector<int>& prefixes, probes::Distribution distribution,
                                               double turn_rad, const RunOptions& options);
struct CheckRequest {
    int receivers = 1024;   // every k-th of all
    int truth_rays = 8192;  // an even number; each receiver turns them about its normal by an angle of its own
    double most_sky = 1;    // receivers of which more than this share of the rays meets nothing are left out
};
CheckedReceivers check_receivers(const LadderWorld& world, const Radiance& radiance, const probes::Receivers& all,
                                 const CheckRequest& request, int bake_rays, probes::Distribution distribution,
                                 const RunOptions& options);

// ---- Transport and probes in double -----------------------------------------------------------------------------------

struct LadderTransport {
    probes::Supports supports;         // of the checked receivers
    std::vector<double> rays, unseen;  // W/m2: after those steps
    std::vector<double> alpha;         // [receiver][slot][64], sr
};
LadderTransport transport_in_double(const LadderWorld& world, const CheckedReceivers& checked, const Buffer<glm::vec4>& probes,
                                    double radius_m, int overlaps, const probes::TransportParams& params,
                                    const RunOptions& options);

// What probes see along their rays.
struct ProbeLight {
    int probes = 0;
    Buffer<glm::vec4> directions;
    std::vector<double> harmonics;  // [ray][64]
    std::vector<float> radiance;    // [probe][ray]

    int rays() const { return int(directions.size()); }
};
// Where no receiver asks (escape says whether rays that meet nothing do) as Unasked::nearest has it.
ProbeLight probe_light(const LadderWorld& world, const Radiance& radiance, const Buffer<glm::vec4>& probes,
                       const Buffer<glm::vec4>& directions, probes::Escape escape, const RunOptions& options);

// Which of many places see most of what receivers see, chosen one after the other: indices, the first `wanted`.
std::vector<int> places_that_see_most(const LadderWorld& world, const CheckedReceivers& checked,
                                      const Buffer<glm::vec4>& places, int wanted, const RunOptions& options);

// lambda by the first rays, weighted as given: [probe][64], in double; and as the run time has it: [probe][coefficient].
std::vector<double> lambda_in_double(const ProbeLight& light, const Buffer<float>& weights, const RunOptions& options);
std::vector<float> lambda_in_float(const ProbeLight& light, const Buffer<float>& weights, int degree,
                                   const RunOptions& options);
// 4 pi / n for each: IPR (10).
Buffer<float> equal_weights(int n);

// Irradiance of all receivers through the clusters, at most `kept` singular values of each.
std::vector<double> clustered_in_double(const probes::Bake& bake, const std::vector<double>& lambda, int kept);
std::vector<float> clustered_in_float(const probes::Bake& bake, const std::vector<float>& lambda);

// ---- Errors -----------------------------------------------------------------------------------------------------------

enum LadderStep : int { step_rays, step_unseen, step_degree, step_relight, step_truncation, step_rounding, ladder_steps };
inline constexpr const char* ladder_step_names[ladder_steps] = {"rays",    "unseen",     "degree",
                                                                "relight", "truncation", "rounding"};

// What each step adds to the checked receivers' irradiance, and what comes of all, W/m2.
struct LadderSteps {
    std::vector<double> value;
    std::array<std::vector<double>, ladder_steps> added;
};
LadderSteps steps_of(const CheckedReceivers& checked, const LadderTransport& transport, const probes::Bake& bake,
                     const std::vector<double>& many, const std::vector<double>& lambda, const std::vector<float>& rounded);

// rms, bias, p95: shares of the truth's mean. local: root mean square of the error of each receiver over its own truth plus the
// mean, so that a few that are very bright do not stand for all.
struct LadderErrors {
    double rms = 0, local = 0, bias = 0, p95 = 0;  // p95: 95 % of the receivers err less
    double black = 0;                              // share of lit receivers that are black: below 1 % of their truth
    std::array<double, ladder_steps> step_rms{}, step_local{}, step_bias{};
};
// Lit: above 1 % of the mean. Throws InputError where the truth is black.
LadderErrors errors_of(const CheckedReceivers& checked, const LadderSteps& steps);
double relative_rms(const CheckedReceivers& checked, const std::vector<double>& difference);
double local_rms(const CheckedReceivers& checked, const std::vector<double>& difference);

// A bilinear lookup of that lightmap, its borders extended, at receivers of another.
std::vector<double> looked_up(const LadderWorld& world, const probes::Bake& bake, const std::vector<float>& irradiance,
                              const probes::Receivers& at);

}  // namespace plumb::cli
