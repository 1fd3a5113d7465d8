// The directions of a bake: rays of probes and of receivers, the same for all probes, and for all receivers in the frames of
// their normals. Progressive: every prefix of 2^n rays is uniform.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "core/image.h"

namespace plumb::probes {

// Rays of receivers: how they are distributed, and so what each weighs.
enum class Distribution : int {
    cosine,   // density cos(theta) / pi, weight pi / N
    uniform,  // density 1 / (2 pi), weight 2 pi cos(theta) / N
};

// Of one set for all: xyz unit, z the pole; w 0.
Buffer<glm::vec4> relight_directions(int rays);
Buffer<glm::vec4> receiver_directions(int rays, Distribution distribution);
// f_k of share_kernel.h, sr. They sum to pi for `cosine`, to pi but for the error of the sum for `uniform`.
Buffer<float> ray_factors(const Buffer<glm::vec4>& directions, Distribution distribution);

// Y_j of each direction: [rays][(degree + 1)^2], IPR 3.2.5.2.
Buffer<float> harmonics_of(const Buffer<glm::vec4>& directions, int degree);

}  // namespace plumb::probes
