// plumb experiment ipr, level of detail: a scene and its bake, lit, and one update of it. Private to ipr_lod*.cpp.
#pragma once

#include <map>

#include "gi/probes/bake.h"
#include "gi/probes/hit_surfaces.h"
#include "gi/probes/lit_hits.h"
#include "tools/experiments/ipr_lod.h"

namespace plumb::cli {

inline double lod_luminance(const glm::vec4& v) { return 0.2126 * double(v.x) + 0.7152 * double(v.y) + 0.0722 * double(v.z); }

// Of so many calls.
double lod_median_ms(const std::function<void()>& once, int times);

// What pixels see: where on the lightmap, and what else lights them.
struct LodSeen {
    probes::RelightHits hits;       // one probe: the eye; a ray a pixel
    Image4 position, normal, albedo, emitted, direct;
    Image<std::uint8_t> compared;   // fronts
    compare::Plane truth, error;    // indirect, path traced, luminance, W/m2; empty: not asked
    Image4 traced;                  // W/m2
};

// One update's inputs and outputs by one setup.
struct LodRun {
    probes::Lod lod;
    probes::RunData data;
    Buffer<float> weights;
    probes::Levels levels;
    Image4 place, before, radiance, lambda, basis, irradiance, lightmap;
    std::vector<std::int32_t> basis_level;
    probes::TilesToWrite tiles;
};

struct LodBench::World {
    World(const Scene& s, const probes::Bake& b, const RunOptions& o) : scene(still_scene(s)), bake(b), options(o) {}

    const Scene scene;
    const probes::Bake& bake;
    const RunOptions& options;
    std::unique_ptr<probes::LitScene> lit;
    probes::HitSurfaces hits;
    Image4 direct;
    probes::LodBoxes boxes;
    std::map<std::string, LodSeen> seen;  // by the view's name
    std::vector<probes::Box> moving;      // what reads the air; empty: nothing
    probes::ClusterData air;
    Image4 air_position, air_normal;      // of vertices of what moves: one row

    LodRun run_of(const probes::LodParams& params, LodBorders borders = LodBorders::all) const;
    void take_levels(LodRun& run, const Camera& camera) const;
    probes::UpdateBuffers buffers(LodRun& run) const;
    LodStageMs stage_ms(LodRun& run, const Camera& camera, int times) const;
    LodSeen seen_by(const LodView& view) const;
    const LodSeen& look(const LodView& view);
    Image4 indirect(const LodRun& run, const LodSeen& seen, const Camera& camera, glm::ivec2 size) const;
    void take_moving(const Scene& scene);
    // light: irradiance at the vertices. reference: the same without levels.
    LodAir in_the_air(LodRun& run, int times, Image4& light, const Image4& reference) const;
};

}  // namespace plumb::cli
