// Clusters as plain arrays, one after the other: for stores and files.
#pragma once

#include "core/bundle.h"
#include "gi/probes/clusters.h"

namespace plumb::probes {

// Cluster c has the elements [first[c], first[c + 1]) of each list.
struct FlatClusters {
    int singular_values = 0;
    std::vector<std::int32_t> first_receiver = {0}, receivers;  // ascending in each cluster
    std::vector<std::int32_t> first_probe = {0}, probes;        // ascending in each cluster: the columns' order
    std::vector<std::int32_t> rank;
    std::vector<std::int32_t> first_row = {0};                  // of all rows of Sigma V^T before
    Buffer<float> sigma_vt;                                     // row by row, each probes x coefficients long
    std::vector<std::int32_t> first_value = {0};
    std::vector<double> spectrum;                               // all singular values, descending
    std::vector<float> box;                                     // [cluster][6]: low, high, m, of its receivers
    std::vector<double> errors;                                 // [cluster][2]: as printed, Frobenius
    std::vector<std::int32_t> cluster_of;                       // [receivers]
    Buffer<float> u;                                            // [receivers][singular_values]

    int count() const { return int(rank.size()); }
};

FlatClusters flat(const Clusters& clusters);
// Throws InputError for lists that do not fit each other, and indices out of range.
Clusters clusters_of(const FlatClusters& flat, int coefficients);

// The lists, lent, by their names; and back from a bundle of such lists.
Bundle lent(const FlatClusters& flat);
FlatClusters flat_clusters(const Bundle& bundle);

}  // namespace plumb::probes
