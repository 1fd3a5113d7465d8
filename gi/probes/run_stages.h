// The steps of the run time that no device could run, as `plumb stages` lists them, and what a bake is expected to take.
#pragma once

#include <string>

#include "core/bundle.h"
#include "core/scene.h"
#include "core/stage.h"
#include "gi/probes/bake_params.h"
#include "gi/probes/lightmap_uv.h"
#include "gi/probes/run_data.h"

namespace plumb::probes {

StageInfo info_run_data();
StageInfo info_hit_surfaces();
StageInfo info_rounds();
StageInfo info_active();
StageInfo info_static_light();

// Of all that the run time reads of a bake.
std::uint64_t bake_key(const Bake& bake);

// Lent, for a graph's keys.
Bundle lent(const RunData& data, const ChartedTriangles& charted, const Buffer<float>& harmonics, const Buffer<float>& weights);

// Before there is a bake: "a bake is made: about 60000 receivers, 30 million rays", by the area of the static surfaces; and
// milliseconds on one core and memory, an order of magnitude.
struct ExpectedBake {
    double receivers = 0, rays = 0, ms = 0, bytes = 0, area_m2 = 0;
};
ExpectedBake expected_bake(const Scene& scene, const BakeParams& params);
std::string text_of(const ExpectedBake& expected);

}  // namespace plumb::probes
