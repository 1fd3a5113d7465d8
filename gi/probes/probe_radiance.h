// The radiance that probes see when light has come to rest between the surfaces of a baked scene: by the bake's own transport, in
// double (converge.h), with lamps and shadows (lit_hits.h).
#pragma once

#include "gi/probes/converge.h"
#include "gi/probes/export_sh.h"

namespace plumb::probes {

// What relight rays find to shine; the scene's own lights, as it stands. The bake is whole and of that scene.
Relit lit_relight(const Bake& bake, const Scene& scene, const RunOptions& options);

struct ProbeRadiance {
    std::vector<glm::dvec3> position;  // m, of each probe
    std::vector<Radiance9> radiance;   // W/(m2 sr)
    int rounds = 0;                    // until no receiver changed by more than 1e-5 of the mean
};

// Throws InputError for a bake of degree 0 or 1 and where light does not come to rest: surfaces that give more than they get.
ProbeRadiance probe_radiance(const Bake& bake, const Scene& scene, const RunOptions& options);

}  // namespace plumb::probes
