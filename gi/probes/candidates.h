// The voxels in which a probe may stand (IPR 3.2.2.1, figure 3.13). Private to gi/probes/placement.cpp and its test.
#pragma once

#include <vector>

#include "core/ray_query.h"
#include "gi/probes/voxels.h"

namespace plumb::probes {

struct Candidates {
    std::vector<glm::ivec3> cells;  // ascending by z, y, x
    std::int64_t in_surface = 0, beyond = 0, behind = 0, without_normal = 0, inside = 0;  // as in Placement
};

// Empty voxels beside a voxel with a surface (of its 26 neighbours), in front of it where it has a normal. Where it has
// none: on any side with `both_sides`, and nowhere beside it without (as printed). The ring of cells around the bounds
// counts along the axes of `beyond`.
Candidates beside_surfaces(const Voxels& voxels, bool both_sides, glm::bvec3 beyond);

// Takes away those inside of objects: of 64 rays from the voxel's centre, of those that hit something, at least 60 % hit
// back faces. Where the first 16, spread as evenly, hit one kind of faces alone, that decides.
//
// differs: IPR 5.1.4 asks that no ray leaves the scene, 4.1 does not and asks for 80 %. Outside of a closed room half of
// the rays leave, and those that hit see the backs of its walls alone: such a probe has nothing to say. Beside a sheet
// with two faces front faces alone are seen; behind one with a single face, no receiver is.
void remove_inside(Candidates& candidates, const Voxels& voxels, const RayQuery& rays, const RunOptions& options);
inline constexpr int test_rays = 64;
inline constexpr double back_share = 0.6;

}  // namespace plumb::probes
