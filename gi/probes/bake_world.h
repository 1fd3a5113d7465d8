// What the nodes of a bake share beside what they make (bake_graph.cpp, bake_blocks.cpp).
#pragma once

#include <memory>
#include <string>

#include "gi/probes/bake.h"
#include "gi/probes/static_scene.h"
#include "gi/reference/ray_query.h"
#include "raster/surfaces.h"

namespace plumb::probes {

// Rays are asked of the atlas' geometry. They are made ready when the first is asked: a bake that lies in the store asks none.
struct BakeGraph::World {
    World(const Scene& s, const Bake& b) : scene(s), bake(b) {}

    const Scene& scene;
    const Bake& bake;
    Geometry geometry;
    float offset = 0;  // known with the atlas

    const raster::Surfaces& surfaces() {
        if (!surfaces_) {
            surfaces_ = std::make_unique<raster::Surfaces>(raster::prepare(scene, bake.atlas.geometry));
            drop_normal_maps(*surfaces_);
        }
        return *surfaces_;
    }
    const RayQuery& query() {
        if (!query_) query_ = reference::build_ray_query(bake.atlas.geometry, surfaces(), bake.params.rays);
        return *query_;
    }
    raster::SurfaceArgs args() { return raster::surface_args(bake.atlas.geometry, surfaces(), View{}); }
    // Of another atlas.
    void forget() { query_.reset(), surfaces_.reset(); }

  private:
    std::unique_ptr<raster::Surfaces> surfaces_;
    std::unique_ptr<RayQuery> query_;
};

// A node without a twin: its name, and why.
graph::Node host_node(const std::string& name, const std::string& reason);

}  // namespace plumb::probes
