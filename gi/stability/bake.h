// Cells of the stages that no frame of the cases has: those of a bake and of its run time (all that are named probes.), of a volume of
// DDGI's probes, and of hemicube radiosity (radiosity.h). Their data are those of a small bake, volume or system of a case's scene, or
// made by hand. gi/probes/README.md derives the conditions of a bake's.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "gi/stability/cases.h"
#include "gi/stability/stability.h"

namespace plumb::probes {
struct Bake;
struct TracedBlock;
}  // namespace plumb::probes

namespace plumb::stability {

// Whether the stage binds data of a bake, of a volume, or of radiosity.
bool is_of_bake(const std::string& stage);

// Whether a bake sees what the case is about: lights, cameras, frames and edits mean nothing to it.
bool is_baked(const Case& c);

// Dispatches of a bake of the scene, on a lightmap of 48 texels a side with 6 probes: candidates, supports, and of the first
// block of receivers the shares of 32 rays, both weightings, and all coefficients to degree 7; and those of relight_data() and
// update_data(). They own their inputs.
// block of receivers the shares of 32 rays, both weightings, and all coefficients to degree 7; points in a grid of spatial receivers. They own their inputs.
std::vector<StageData> bake_data(const Scene& scene, const RunOptions& options);

// Of its first block, the run time's update of a few receivers, in clusters of fewer than 40, under a light of no scene.
std::vector<StageData> update_data(const probes::Bake& bake, const probes::TracedBlock& block, const RunOptions& options);

// Dispatches of a volume of 2 x 2 x 2 probes over the scene, of 32 rays each, after three rounds.
std::vector<StageData> volume_data(const Scene& scene, const RunOptions& options);

// Data that no scene has: probes in one place, rays of no length, directions at a pole.
struct BakeCase {
    std::string name, group, meaning;  // as those of Case
    std::function<std::vector<StageData>()> data;
};
const std::vector<BakeCase>& bake_cases();
void add_update_cases(std::vector<BakeCase>& cases);

// A cell for each stage of the data, or for `stage` alone. What a stage refuses is a cell that is `refused`.
std::vector<Cell> bake_cells(const std::vector<StageData>& data, const std::string& stage, const Effort& effort);
// The same of a scene's bake, volume and radiosity. Where the atlas or radiosity refuses the scene, each of their stages is refused.
std::vector<Cell> bake_cells(const Scene& scene, const std::string& stage, const Effort& effort);

}  // namespace plumb::stability
