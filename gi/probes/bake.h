// The bake of irradiance probes (IPR 3.2): what is known of a scene before there is light in it. Its steps are nodes of a
// graph (gi/graph), in this order:
//
//     probes.atlas         where on the lightmap each surface lies
//     probes.receivers     its texels, drawn, and moved out of what they lie in
//     probes.placement     where probes stand, and how far they reach
//     probes.supports      which of them support a receiver                                    a stage
//     probes.spatial       receivers in the air, for dynamic objects; with spatial_receivers alone
//     probes.directions    in which directions a probe looks, and what each counts
//     probes.relight       where it looks for radiance, a block of probes a node
//     probes.coefficients  the transport, a block of receivers a node: probes.share and probes.coefficients are its stages
//     probes.clusters      the transport, compressed
//
// What each makes is kept in the store, where there is one. A part i of n computes every n-th block: another run finds them in
// the store, and what it makes of them has the same bits.
#pragma once

#include <deque>
#include <memory>

#include "gi/graph/graph.h"
#include "gi/probes/bake_params.h"
#include "gi/probes/fit.h"
#include "gi/probes/flat_clusters.h"
#include "gi/probes/relight.h"
#include "gi/probes/spatial.h"
#include "gi/probes/transport.h"

namespace plumb::probes {

inline constexpr int block_receivers = 1024, block_probes = 64;

AtlasParams atlas_params(const BakeParams& p);
ShiftParams shift_params(const BakeParams& p);
ClusterParams cluster_params(const BakeParams& p);
// sky: whether the environment sends anything. Under a sky that sends light the first solution loses it (a uniform sky then
// gives less than pi L); where it sends none, the first leaks least (IPR 5.1.3.1).
bool sends_light(const Environment& sky);
TransportParams transport_params(const BakeParams& p, bool sky);

struct Bake {
    BakeParams params;
    TransportParams transport;             // as the scene's sky has it
    std::uint64_t scene_hash = 0;          // scene_hash()
    std::uint64_t scene_bytes = 0;         // bytes_of_scene()
    Atlas atlas;
    Receivers receivers;
    int shifted = 0;                       // receivers that were moved
    Placement placement;
    ProbeRadius radius;
    Supports supports;
    Buffer<glm::vec4> relight_directions;  // [relight_rays]
    Buffer<float> relight_weights;         // [relight_rays]: of all of them, sr
    Buffer<float> harmonics;               // [relight_rays][(degree + 1)^2]: Y_j of each
    RelightHits relight;
    Buffer<float> alpha;                   // [receivers][overlaps][(degree + 1)^2], sr
    std::vector<RayCounts> block_counts;   // of each block's rays
    Clusters clusters;
    FlatClusters flat;                     // the same, as it is kept
    ClusterReport cluster_report;          // of clusters that were made here
    Spatial spatial;                       // empty without spatial_receivers

    int coefficients() const { return (params.degree + 1) * (params.degree + 1); }
    RayCounts counts() const;
    int blocks() const { return blocks_of(receivers.count()); }
    int spatial_blocks() const { return blocks_of(spatial.receivers.count()); }
    static int blocks_of(int receivers) { return (receivers + block_receivers - 1) / block_receivers; }
};

// Of all that a bake depends on but its parameters: the geometry, which material each triangle has, and where materials are
// cut out by their masks. Light, reflectance and emission are the run time's. A bake's geometry is flatten_static(scene).
std::uint64_t scene_hash(const Scene& scene, const Geometry& geometry);

struct Part {
    int index = 0, count = 1;
};

// The share of what a receiver of a whole bake sees that probes tell it, by the cosine: the irradiance under a radiance of 1 from
// everywhere, over pi. 1 to rounding where probes see all; the published weight gives others.
float told_share(const Bake& bake, int receiver);

// Receivers of a whole bake, with probes, that nothing reaches.
int black_receivers(const Bake& bake);

class BakeGraph {
  public:
    // Bakes the scene's static meshes (static_scene.h). The scene must outlive it. memory_limit: bytes; a bake that needs more (memory.h) is refused once that is known. Throws
    // InputError for parameters out of range.
    BakeGraph(const Scene& scene, const BakeParams& params, Part part = {}, std::uint64_t memory_limit = ~std::uint64_t(0));
    ~BakeGraph();

    const std::vector<const graph::Node*>& nodes() const { return first_; }
    // Of those the ones up to the supports: what traced() needs.
    std::vector<const graph::Node*> nodes_before_rays() const { return {first_.begin(), first_.begin() + 4}; }
    const Bake& bake() const { return bake_; }
    Bake release() { return std::move(bake_); }  // after the run; the graph is of no more use
    // Called when receivers and probes are known, before the rays.
    void when_sized(std::function<void(std::uint64_t bytes)> call) { sized_ = std::move(call); }
    // Of the block that holds the receiver: what its stages are given, traced anew.
    TracedBlock traced(int receiver, const RunOptions& options) const { return traced(receiver, query(), options); }
    // The same, asking another query: one that looks at what is asked.
    TracedBlock traced(int receiver, const RayQuery& query, const RunOptions& options) const;
    const RayQuery& query() const;
    const raster::Surfaces& surfaces() const;
    // Blocks of receivers that this part computes, those in the air included.
    int blocks_here() const { return of_part(bake_.blocks()) + of_part(bake_.spatial_blocks()); }
    // bytes_needed(), once it is known.
    std::uint64_t bytes() const { return bytes_; }
    // Seconds that went into rays, and what probes.share made of them, of the blocks that ran.
    double seconds_of_rays() const { return seconds_of_rays_; }

  private:
    struct World;
    graph::Node atlas_node();
    graph::Node receivers_node();
    graph::Node placement_node();
    graph::Node supports_node();
    graph::Node rays_node();
    graph::Node relight_node(int first, int count);
    graph::Node coefficients_node(int block, bool spatial);
    graph::Node clusters_node();
    graph::Node spatial_node();
    graph::Node spatial_clusters_node();
    int of_part(int blocks) const { return (blocks - part_.index + part_.count - 1) / part_.count; }
    TracedBlock trace(bool spatial, int first, const RayQuery& query, const RunOptions& options) const;
    Fit& fit(const RunOptions& options);
    void check_memory();
    std::vector<const graph::Node*> add_blocks();
    void read_rays(graph::Reads& reads) const;

    Part part_;
    std::uint64_t memory_limit_;
    Bake bake_;
    std::unique_ptr<World> world_;
    std::unique_ptr<Fit> fit_;
    std::deque<graph::Node> nodes_;
    std::vector<const graph::Node*> first_;
    double seconds_of_rays_ = 0;
    std::uint64_t bytes_ = 0;
    std::function<void(std::uint64_t)> sized_;
};

}  // namespace plumb::probes
