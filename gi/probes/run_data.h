// What the run time reads of a bake, laid out as its stages read it (IPR 3.2.5, 3.3.1): receivers in the order of their
// clusters, matrices with the singular value fastest, U with the receiver fastest.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "core/image.h"
#include "gi/probes/flat_clusters.h"
#include "gi/probes/lightmap_kernel.h"
#include "gi/probes/lightmap_tiles.h"

namespace plumb::probes {

struct Bake;
struct BakeArrays;

// Clusters and the receivers in them. A receiver's place is its index in these lists: cluster by cluster, within each the coarsest
// level of detail first, then ascending, and at the end those that no probe supports. So a cluster of which a level alone is
// computed has that level's receivers side by side. The receivers may be texels of a lightmap or points in space.
struct ClusterData {
    int coefficients = 0, singular_values = 0;
    std::vector<glm::ivec4> clusters;          // first number of its matrix, first of its probes, probes, rank
    std::vector<std::int32_t> cluster_probes;  // cluster by cluster
    Buffer<float> matrix;                      // Sigma V^T, cluster by cluster: [probes x coefficients][rank]
    std::vector<std::int32_t> receiver;        // [places]
    std::vector<std::int32_t> place_of;        // [receivers]: back
    std::vector<std::int32_t> cluster;         // [places]; -1: none
    Buffer<float> u;                           // [singular_values][places]

    int count() const { return int(receiver.size()); }  // places
};
// level: [receivers] of detail; empty: 0. Throws InputError for lists that do not fit each other, and for more numbers than a
// device's index reaches.
ClusterData cluster_data(const FlatClusters& flat, int receivers, int coefficients, const std::vector<std::int32_t>& level = {});

struct RunData : ClusterData {
    int probes = 0, rays = 0, levels = 1;
    std::vector<std::int32_t> receiver_level;  // [places]: the coarsest level of detail that shows it (IPR 4.2.3)
    std::vector<std::int32_t> coarsest;        // [clusters]: of its receivers; -1 without any
    Image<std::int32_t> cover;                 // [strip]: place of the receiver; or one of Cover
    glm::ivec2 lightmap_size{0};               // of the strip
    LightmapTiles tiles;                       // of the strip; empty of data textures, which hold no charts
};
// Throws InputError for levels other than 1 to most_levels (lightmap_kernel.h).
RunData run_data(const Bake& bake, int levels = 1);
// The same of data textures that were read back (textures.h). side: of the lightmap, which they do not hold.
RunData run_data(const BakeArrays& arrays, int side, int levels = 1);

// What probes.basis is given for levels: -1, no coefficients, for a cluster that is so coarse that none of its receivers is computed.
std::vector<std::int32_t> basis_levels(const RunData& data, const std::vector<std::int32_t>& cluster_level);

// ---- The lightmap's levels --------------------------------------------------------------------------------------------

// Texels of the strip where no receiver is: nothing, or beside receivers (1), or beside those (2).
enum Cover : std::int32_t { cover_nothing = -1, cover_ring_1 = -2, cover_ring_2 = -3 };

// How many trailing zero bits both coordinates have, at most levels - 1.
int level_of_texel(glm::ivec2 texel, int levels);
// The coarsest level that shows each receiver: that of its texel. A chart too small or too thin to have a receiver in some level
// has its receivers stand for the texels of that level which they touch and no other receiver has, the first of each.
//
// differs: in the thesis such charts are black from that level on.
std::vector<std::int32_t> receiver_levels(const Bake& bake, int levels);

// Of levels as lightmap_kernel.h has them: texel (x, y) of level k shows the receiver at texel (x << k, y << k) of level 0. Rings as
// extend_borders() has them, in each level for itself. place_of: [receivers]. Throws InputError for a texel beyond the lightmap, or
// one with two receivers.
Image<std::int32_t> lightmap_cover(const std::vector<glm::ivec2>& texels, const std::vector<std::int32_t>& place_of, int side,
                                   int levels);
// The same, receiver i in levels 0 to level[i].
Image<std::int32_t> lightmap_cover(const std::vector<glm::ivec2>& texels, const std::vector<std::int32_t>& place_of, int side, int levels,
                                   const std::vector<std::int32_t>& level);

}  // namespace plumb::probes
