// The un-truncated transport: which probes support a receiver, and its coefficients, a block of receivers at a time.
#pragma once

#include <vector>

#include "core/isa.h"
#include "core/ray_query.h"
#include "gi/probes/directions.h"
#include "gi/probes/receiver_rays_kernel.h"
#include "gi/probes/receivers.h"
#include "gi/probes/supports.h"

namespace plumb::probes {

struct TransportParams {
    int rays = 512;  // of each receiver
    int degree = 7;
    Distribution distribution = Distribution::cosine;
    Escape escape = Escape::nothing;
    bool published_weight = false;  // by the ray's length, IPR 5.1.3.2
    bool fitted = false;            // fit.h; of the probes' first relight_rays
    int relight_rays = 512;
};

// What all receivers share.
struct TransportScene {
    raster::SurfaceArgs surfaces;
    const RayQuery* query = nullptr;
    float offset = 0;                        // m, off surfaces
    const Buffer<glm::vec4>* probes = nullptr;
    Buffer<glm::vec4> directions = {};       // of a receiver's rays
    Buffer<float> factors = {};
};

// Inputs of both stages for the receivers [first, first + count): what was traced.
struct TracedBlock {
    int first = 0, count = 0, rays = 0, slots = 0;
    Buffer<glm::vec4> supporting;      // [slots][count]: xyz the probe, m; w its weight, 0: none
    Buffer<glm::vec4> seen;            // [rays][count]
    Buffer<glm::vec4> normals;         // [rays][count]: of what was met, unit; empty unless the transport is fitted
    std::vector<std::int32_t> visible; // [rays][count]
    Buffer<float> lengths;             // [rays][count]
    Buffer<float> shares;              // [rays][count], probes.share
    Buffer<float> factors;             // [rays], sr
    RayCounts counts;
};
// Traces, and weighs what was met.
TracedBlock trace_block(const TransportScene& scene, const TransportParams& params, const Receivers& receivers,
                        const Supports& supports, int first, int count, const RunOptions& options);

// alpha of the block: [count][overlaps][(degree + 1)^2], sr.
void block_coefficients(const TracedBlock& block, const TransportParams& params, const RunOptions& options, float* alpha);

// ---- What the run time computes of it, in double, for tests and experiments ------------------------------------------

// lambda_ij = sum_r w_r f(r) Y_j(r): [probes][(degree + 1)^2], of radiances [probes][rays] and relight_weights(); IPR (10) has
// w_r = 4 pi / N.
std::vector<glm::dvec3> probe_coefficients(const std::vector<glm::dvec3>& radiance, int probes, const Buffer<float>& weights,
                                           const Buffer<float>& harmonics, int degree);
// E_i = sum over slots and coefficients of alpha_ij lambda_ij; IPR (5).
std::vector<glm::dvec3> irradiance(const Supports& supports, const Buffer<float>& alpha, int degree,
                                   const std::vector<glm::dvec3>& lambda);

}  // namespace plumb::probes
