// The tree of receivers (IPR 3.2.4.1, figures 3.18, 3.19): a cell is halved at the middle of its longest axis.
#pragma once

#include <utility>
#include <vector>

#include "gi/probes/clusters.h"

namespace plumb::probes {

struct TreeCell {
    glm::dvec3 low{0}, high{0};
    std::vector<std::int32_t> receivers;  // ascending
};

// All receivers that have a probe, and their box.
TreeCell whole_tree(const TransportRows& rows);

// Of the receivers themselves, at least one.
std::pair<glm::dvec3, glm::dvec3> box_of(const TransportRows& rows, const std::vector<std::int32_t>& receivers);

// Both halves have receivers: where no halving comes between two of them, they are split at the median of their own box, and
// the result is false. At least two receivers.
bool split(const TransportRows& rows, const TreeCell& cell, TreeCell (&half)[2]);

// What the clusters of a transport may take at most, whatever its alphas: the largest sums over all ways in which the tree may
// end. Only positions and supports are read.
struct ClusterBound {
    std::uint64_t matrices = 0;   // numbers of all Sigma V^T
    std::uint64_t spectrum = 0;   // singular values
    std::uint64_t lists = 0;      // receivers and probes of clusters and of cells
    std::uint64_t clusters = 0;
    std::uint64_t workspace = 0;  // bytes of the largest decomposition
};
ClusterBound cluster_bound(const TransportRows& rows, const ClusterParams& params);

}  // namespace plumb::probes
