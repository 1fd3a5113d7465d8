// Painted textures of the scenes that show buildings. Each tiles; each depends on its seed alone.
#pragma once

#include <cstdint>
#include <string>

#include "core/scene.h"

namespace plumb::io::scenes::textures {

// Squared stone in courses: `columns` blocks by `rows` courses, every other course shifted by half a block. The normal
// map fits the colours of the same columns, rows and seed: worn edges around joints that lie back.
struct Blocks {
    int columns = 4, rows = 6;
    double joint = 0.012;              // half a joint's width, in texture sides
    glm::dvec3 stone{0.52, 0.46, 0.38}, mortar{0.40, 0.37, 0.33};  // reflectances
    double variety = 0.16;             // of the blocks' tone, relative
    std::uint32_t seed = 1;
};
Texture blocks(const std::string& name, const Blocks& blocks);
Texture blocks_normals(const std::string& name, const Blocks& blocks, double depth = 0.012);

// Without a pattern: a tone with clouds and grain, `contrast` from trough to crest, relative.
Texture stone(const std::string& name, const glm::dvec3& tone, double contrast, std::uint32_t seed);

// Polished slabs, `tiles` x `tiles`, in two tones like a chessboard, veined, with thin joints.
Texture marble(const std::string& name, int tiles, const glm::dvec3& light, const glm::dvec3& dark, std::uint32_t seed);

// Boards along v, `boards` across.
Texture wood(const std::string& name, int boards, const glm::dvec3& tone, std::uint32_t seed);

// Woven cloth with a damask pattern: pale, to be multiplied by the material's colour.
Texture fabric(const std::string& name, std::uint32_t seed);

// Fired clay with streaks along v.
Texture clay(const std::string& name, const glm::dvec3& tone, std::uint32_t seed);

// Leaves before nothing: alpha is 0 between them. For materials with alpha_cutoff 0.5.
Texture leaves(const std::string& name, std::uint32_t seed);

}  // namespace plumb::io::scenes::textures
