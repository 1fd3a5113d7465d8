// Spatial receivers (IPR 4.1): irradiance in the air, for what moves. Places stand on a regular grid over the static scene; at each
// six receivers look along the axes. What dynamic objects are lit by lies between places: gi/probes/volume.h.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "gi/probes/clusters.h"
#include "gi/probes/directions.h"
#include "gi/probes/flat_clusters.h"
#include "gi/probes/receivers.h"
#include "gi/probes/receiver_rays_kernel.h"
#include "gi/probes/spatial_weight.h"
#include "gi/probes/supports.h"

namespace plumb::probes {

inline constexpr int spatial_directions = 6;  // +x -x +y -y +z -z, in this order wherever they are listed
glm::vec3 spatial_direction(int d);

// Place (x, y, z) stands at origin + (x, y, z) spacing; its index is x + count.x (y + count.y z).
struct SpatialGrid {
    glm::ivec3 count{0};
    glm::vec3 origin{0}, spacing{1};  // m

    int places() const { return count.x * count.y * count.z; }
};
// About `wanted` places over the box, by IPR (1) to (3): cells as near to cubes as whole numbers allow. Throws InputError for a box
// without extent or one that is not finite, and for fewer than 1.
//
// differs: IPR says that places are a grid's vertices, not where the grid ends. Here they are the middles of equal boxes: on the
// faces of a closed room half of what they see is behind its walls. `inset`: how far the outer ones are from the box' faces, in
// spacings; 0: on them.
SpatialGrid spatial_grid(const glm::vec3& low, const glm::vec3& high, int wanted, double inset = 0.5);

// What a bake knows of them. Receiver d places + i looks along direction d from place i.
struct Spatial {
    SpatialGrid grid;
    Receivers receivers;                   // position, normal and shift alone: in the air there is no lightmap
    int shifted = 0;                       // places that were moved out of what they lay in
    float radius = 0;                      // m, of probes for these receivers
    Supports supports;
    Buffer<float> alpha;                   // [receivers][overlaps][coefficients], sr
    std::vector<RayCounts> block_counts;   // of each block's rays
    Clusters clusters;                     // of one direction each
    FlatClusters flat;                     // the same, as it is kept

    bool empty() const { return receivers.count() == 0; }
};

struct SpatialParams {
    int wanted = 0;
    int test_rays = 64;      // of each place, over the sphere; 0: none is moved
    double back_share = 0.8; // IPR 4.1.1: of those that meet something this share has to start inside of something
};
// Grid, receivers and their supports. radius: m, of the probes for receivers on surfaces.
//
// differs: IPR has one radius. Probes stand near surfaces, and their radius is what receivers there need: in the middle of a hall none
// would reach. Here it is at least what gives each place as many probes as it has slots.
Spatial place_spatial(const glm::vec3& low, const glm::vec3& high, const SpatialParams& params, const raster::SurfaceArgs& surfaces,
                      const RayQuery& query, float offset, const Buffer<glm::vec4>& probes, float radius, int overlaps,
                      const RunOptions& options);

// What each of a receiver's rays counts for, sr (directions.h).
Buffer<float> spatial_factors(const Buffer<glm::vec4>& directions, Distribution distribution, SpatialWeight weight);

// Of each direction alone (IPR 4.1: what looks along one direction is more coherent), one after the other.
Clusters spatial_clusters(const Spatial& spatial, int coefficients, const ClusterParams& params, const RunOptions& options);

// ---- Run time ----------------------------------------------------------------------------------------------------------

struct Box {
    glm::vec3 low{0}, high{0};  // m
};
// Of a mesh, in world space; low above high for one without vertices.
Box box_of(const Mesh& mesh);
// Of each dynamic mesh but those at these places of Scene::meshes, which ascend.
std::vector<Box> dynamic_boxes(const Scene& scene, const std::vector<int>& left_out = {});

// The cells that a box touches, each called by its first place, and as much more as positions rounded to half floats may be off. Beyond
// the grid those at its edge. Throws InputError for a box that is not finite.
struct CellRange {
    glm::ivec3 first{0}, last{0};
    glm::dvec3 margin{0};  // m
};
CellRange cells_of(const SpatialGrid& grid, const Box& box);

// Which places a lookup within the boxes reads, 1 each: the corners of their cells (figure 4.2).
std::vector<std::uint8_t> active_places(const SpatialGrid& grid, const std::vector<Box>& boxes);
// What probes.irradiance is given as receiver_level: `coarsest` of clusters' levels for active places, -1 of others, which it does not
// compute. receiver: that of ClusterData (run_data.h).
std::vector<std::int32_t> active_levels(const SpatialGrid& grid, const std::vector<std::uint8_t>& active,
                                        const std::vector<std::int32_t>& receiver, int coarsest = 0);
// What probes.basis and probes.irradiance are given as cluster_level: 0 of clusters with a place that is active, no_level of the rest,
// whose matrix is not read. active: that of active_levels(); cluster: that of ClusterData.
std::vector<std::int32_t> active_clusters(const std::vector<std::int32_t>& active, const std::vector<std::int32_t>& cluster, std::size_t clusters);

// [place][direction], as probes.volume reads it, of what probes.irradiance wrote. receiver: that of ClusterData.
void gather_grid(const SpatialGrid& grid, const std::vector<std::int32_t>& receiver, const Buffer<glm::vec4>& irradiance,
                 Buffer<glm::vec4>& gathered);

}  // namespace plumb::probes
