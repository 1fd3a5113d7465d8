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

// Weights of the first n relight directions, sr: they integrate all harmonics up to exact_degree(n) exactly, and differ least
// from 4 pi / n. With 512 rays that is degree 14: the Y_j up to degree 7, as they are sampled, are orthonormal.
//
// differs: IPR (10) weighs all rays alike, 4 pi / n. Of 512 such rays the coefficients of a constant radiance are off by 6 % of
// the first one.
Buffer<float> relight_weights(const Buffer<glm::vec4>& directions, int n);
// 14 for 512 rays, 10, 7, 4 for 256, 128, 64: the most of which there are two rays a harmonic; 14 at most.
int exact_degree(int n);

// Y_j of each direction: [rays][(degree + 1)^2], IPR 3.2.5.2.
Buffer<float> harmonics_of(const Buffer<glm::vec4>& directions, int degree);

}  // namespace plumb::probes
