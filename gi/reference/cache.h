// What the bits of an estimate depend on, as one number, and where estimates are kept by it.
#pragma once

#include <cstdint>
#include <optional>

#include "gi/reference/reference.h"

namespace plumb::reference {

// Of trace(): parameters, seed, camera, frame and all of the scene that a ray can meet. The names of things, the
// convention and the settings of other stages are no part of it. Exact rays give the same bits everywhere; of native
// ones the instruction set, the processor and Embree's version count as well. Which program traced is no part of it
// either: a store that outlives one adds that. `geometry`: flatten(scene).
std::uint64_t cache_key(const PathParams& params, const Scene& scene, const Geometry& geometry, std::uint32_t seed,
                        Isa isa);
// Of trace_irradiance(): the points in place of the camera.
std::uint64_t cache_key(const PathParams& params, const Scene& scene, const Geometry& geometry,
                        const PointInputs& points, std::uint32_t seed, Isa isa);
// Of trace_reflection(): the eye beside them.
std::uint64_t cache_key(const PathParams& params, const Scene& scene, const Geometry& geometry,
                        const PointInputs& points, const glm::dvec3& eye, std::uint32_t seed, Isa isa);

struct KeptEstimate {
    Estimate estimate;
    double ms = 0;  // that tracing it took
};

// Somewhere that outlives a run. Neither function throws: what cannot be found is traced, what cannot be kept is not.
class Store {
  public:
    virtual ~Store() = default;
    // The estimate of that key, of `size` pixels; nothing where there is none to be trusted.
    virtual std::optional<KeptEstimate> find(std::uint64_t key, glm::ivec2 size) = 0;
    virtual void keep(std::uint64_t key, const KeptEstimate& kept) = 0;
};

}  // namespace plumb::reference
