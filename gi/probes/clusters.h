// Receiver clustering with truncated singular value decomposition (IPR 3.2.4, figures 3.18 to 3.21).
//
// The matrix A of a cluster has a row a receiver and, a probe that supports any of them, a column a coefficient:
// irradiance = A lambda. Cut off after few singular values it is U (Sigma V^T): Sigma V^T goes to the cluster, U to its
// receivers.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "core/image.h"
#include "core/isa.h"
#include "gi/probes/svd.h"

namespace plumb::probes {

struct ClusterParams {
    int singular_values = 32;   // kept at most; 4..64
    double threshold = 0.005;   // accepted below: 1 - sqrt(sum_32 s / sum s), as printed (IPR 3.2.4.2)
    int most_receivers = 1024;  // a cluster has fewer than this; 2..4096
    int always_accepted = 32;   // receivers or fewer; 1 or more
    bool by_size_only = false;  // figure 3.18: no threshold-based splitting
};

// What is clustered: the un-truncated transport, row by row sparse.
struct TransportRows {
    int receivers = 0, overlaps = 0, coefficients = 0;  // overlaps: slots a receiver (10), coefficients: 1, 4, 9 ... 64
    const glm::vec4* position = nullptr;                // [receivers] m; w is not read
    const std::int32_t* support = nullptr;              // [receivers][overlaps]: probe, or -1
    const float* alpha = nullptr;                       // [receivers][overlaps][coefficients]; not read where -1
};

struct Cluster {
    std::vector<std::int32_t> receivers;   // ascending
    std::vector<std::int32_t> probes;      // ascending; columns of A are probes x coefficients in this order
    int rank = 0;                          // singular values kept
    std::vector<float> sigma_vt;           // [rank][probes * coefficients]
    std::vector<double> singular_values;   // those kept, descending
    std::vector<double> spectrum;          // all of them, descending: min(receivers, columns)
    double sum_of_all = 0;                 // of the spectrum
    double error_published = 0;            // 1 - sqrt(sum of kept / sum of all), as printed
    double error_frobenius = 0;            // sqrt(sum_{>k} s^2 / sum s^2)
    glm::vec3 low{0}, high{0};             // box of the cluster's receivers, m
    glm::dvec3 cell_low{0}, cell_high{0};  // the tree's box they were found in, m
};

struct Clusters {
    std::vector<Cluster> clusters;         // depth first, low side first
    std::vector<std::int32_t> cluster_of;  // [receivers]; -1 without probe
    int singular_values = 0;
    Buffer<float> u;  // [receivers][singular_values], 0 beyond the cluster's rank
};

// What was done. Counts are the same on every machine, seconds are those of all threads together.
struct ClusterReport {
    int decompositions = 0;    // begun
    int rejected = 0;          // of these
    int rejected_early = 0;    // of the rejected: by a bound, before all singular values were known
    int without_probe = 0;     // receivers
    int coincident = 0;        // clusters above the threshold whose receivers lie in one point
    int split_at_median = 0;   // cells whose spatial middle never came between two receivers
    std::vector<int> of_rank;  // [singular_values + 1]: clusters of each rank
    SvdSeconds seconds;
    double wall_seconds = 0;
};

// Splits the receivers' box at the middle of its longest axis until each part is accepted: fewer receivers than
// most_receivers, and (unless by_size_only) an error below the threshold, or no more than always_accepted receivers.
// Throws InputError for parameters out of range, a position or alpha that is not finite, |alpha| > 1e36, a probe that a
// receiver has twice.
//
// differs: an empty half is no cluster but the other half goes on as the cell; where 192 halvings in a row leave one
// empty, the receivers are split at the median of their own box. The thesis says nothing of either.
Clusters make_clusters(const TransportRows& rows, const ClusterParams& params, const RunOptions& options,
                       ClusterReport* report = nullptr);

// Errors of a cluster cut off after `kept` singular values: figures of accuracy against storage without another
// decomposition. Exact for any `kept` (the spectrum is whole).
struct TruncationError {
    double published, frobenius;
};
TruncationError truncation_error(const Cluster& cluster, int kept);
// The same over all clusters: sums of all their tails over sums of all their singular values.
TruncationError truncation_error(const Clusters& clusters, int kept);

}  // namespace plumb::probes
