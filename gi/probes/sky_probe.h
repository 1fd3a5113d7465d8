// The sky as one more probe: it stands at infinity, all its rays meet nothing, and it tells rays of receivers that meet nothing what
// comes from their own direction (Escape::sky). What hides the sky is in a receiver's coefficients, where rays have found it, and not
// in a probe's harmonics, which have no edges. differs: IPR 5.1.3.1 asks probes whose ray in the same direction meets nothing.
#pragma once

#include "core/image.h"
#include "gi/probes/placement.h"
#include "gi/probes/supports.h"

namespace plumb::probes {

inline constexpr float sky_distance = 1e18f;  // m: no radius reaches it, and its square is a float
inline const glm::vec4 sky_probe(sky_distance, sky_distance, sky_distance, 0);

inline bool is_sky(const glm::vec4& probe) { return probe.x == sky_distance; }

// Probes that stand in the scene: without the sky, which is the last.
inline int standing_probes(const Buffer<glm::vec4>& probes) {
    return int(probes.size()) - (!probes.empty() && is_sky(probes.back()) ? 1 : 0);
}

inline void add_sky(Placement& placement) { placement.probes.push_back(sky_probe), placement.candidate.push_back(-1); }

// One slot more, the last: the sky, of weight 1, where the last of `probes` is the sky.
void add_sky(Supports& supports, const Buffer<glm::vec4>& probes);

}  // namespace plumb::probes
