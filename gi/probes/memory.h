// How much memory a bake takes beyond the program itself, told before it takes it: bounds from above; README.md, Memory, has
// how near they are. Pictures and textures of a bake that is done are not in it.
#pragma once

#include <cstdint>
#include <string>

#include "gi/probes/bake.h"

namespace plumb::probes {

// Of a scene as it was read, with its textures.
std::uint64_t bytes_of_scene(const Scene& scene);

// What fit.h holds: of each probe what its rays met and their weights; of a block the products of pairs of probes; of a thread a matrix
// of all probes of a receiver, its factor, and one pair's covariances.
struct FitSize {
    std::uint64_t probes = 0, rays = 0, overlaps = 0;
    int degree = 0;
};
std::uint64_t bytes_of_fit(const FitSize& of, int threads);

// Until the receivers are known, when the atlas is: the lightmap as it is drawn.
std::uint64_t bytes_to_draw(const Bake& bake);

// When receivers, probes and supports are known: a part's share of the transport, and, of a whole bake, its clusters by
// cluster_bound(), twice, as they are made and as they are kept. threads: that decompose matrices.
std::uint64_t bytes_needed(const Bake& bake, const Part& part = {}, int threads = 1);

// "1.4 GB", "23 MB".
std::string size_text(std::uint64_t bytes);

// Throws InputError for what does not fit: "probes: WHAT need 3.1 GB of memory; there are 2.0 GB: lower LOWER".
void require_memory(const std::string& what, std::uint64_t needed, std::uint64_t there, const std::string& lower);

}  // namespace plumb::probes
