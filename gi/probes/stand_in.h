// Directions of a probe that nobody asks: rays that meet a back and, where rays that meet nothing bring nothing or ask the sky itself
// (Escape::nothing, sky), those. No receiver reads a probe's harmonics there, so that any radiance will do; but a finite number of
// harmonics blurs what lies on either side of the edge into the other. With black, light that receivers see is lost to where nobody
// looks: 2.5 % a bounce in a Cornell box with 128 probes and degree 7. differs: IPR 3.2.3.1 is black there.
//
// `nearest` continues what is seen: the ray tells what the nearest one that is asked has found.
#pragma once

#include <cstdint>
#include <vector>

#include "core/image.h"
#include "core/isa.h"
#include "gi/probes/run_params.h"

namespace plumb::probes {

enum class Escape : int;  // receiver_rays_kernel.h
struct Bake;

// Of each ray the one that tells in its place, both as indices of [probes][rays]: itself where it is asked (`asked` not 0) or none of
// its probe is, else the ray of its probe that is asked and has the largest cosine with it, the first of equals.
std::vector<std::int32_t> stand_ins(const Buffer<glm::vec4>& directions, const std::vector<std::uint8_t>& asked, const RunOptions& options);

// What receivers ask of relight rays [probes][rays]: 1, else 0. material: RelightHits::material; standing: probes without the sky.
// black: all, so that each ray tells what it found.
std::vector<std::uint8_t> asked_rays(const std::vector<std::int32_t>& material, int rays, int standing, Escape escape, Unasked unasked);

// Of a bake's relight rays. black: each for itself.
std::vector<std::int32_t> stand_ins(const Bake& bake, Unasked unasked, const RunOptions& options);

}  // namespace plumb::probes
