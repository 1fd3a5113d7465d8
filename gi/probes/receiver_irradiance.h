// The truth at receivers: their irradiance by path tracing (gi/reference), with its standard error. It serves any list of
// receivers, those of a bake's atlas and those of a mesh's own layout alike. Host only: gi/reference says why.
#pragma once

#include <cstdint>

#include "gi/probes/receivers.h"
#include "gi/reference/reference.h"

namespace plumb::probes {

struct ReceiverIrradiance {
    Buffer<glm::vec4> mean;     // [receiver] W/m2, rgb; w 0
    Buffer<glm::vec4> error;    // [receiver] W/m2, standard error of the mean, by channel; w 0
    int samples = 0;            // a receiver
    int rounds = 0;             // independent estimates that the standard error stands on
    std::uint64_t rays = 0;
    std::size_t nonfinite = 0;  // values that are not finite; they stay
    double relative_error = 0;  // sqrt(mean of error^2) / mean of mean, over all receivers and channels
};

// What reaches each receiver from the side of its normal. params.mode is the part of it: `direct` has met no surface on its
// way from a light, `one_bounce` one, `indirect` one or more, `all` is everything. What leaves a diffuse receiver of
// reflectance rho by reflection is rho E / pi, W/(m2 sr). scene: reference::prepare() of the scene that the receivers are of.
//
// A receiver is a point: the centre of its texel, from where it looks. The light between centres is not averaged.
//
// The same bits for every number of threads, and with exact rays for every instruction set. Receiver i draws the same numbers
// whatever the others are, as long as their count is the same. Throws what reference::trace_irradiance() throws, and
// InputError for `ambient_occlusion`, which is no light.
ReceiverIrradiance receiver_irradiance(const Receivers& receivers, const reference::PathScene& scene,
                                       const reference::PathParams& params, std::uint32_t seed, const RunOptions& options);

}  // namespace plumb::probes
