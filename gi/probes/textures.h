// The data textures of IPR 3.2.5: from the plain arrays of a bake to what a GPU binds, texel by texel, and back.
//
// An item is what the thesis stores under one index: a cluster's matrix, a receiver's transport vector. Items lie in a
// grid, item i in column i % columns and row i / columns, so that no texture is longer than a GPU allows. README.md has
// every texture's layout, what is printed and what was decided here.
#pragma once

#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "core/bundle.h"

namespace plumb::probes {

struct Bake;

struct BakedReceiver {
    glm::vec3 position{0};  // m
    glm::ivec2 texel{0};    // of the lightmap
    int material = 0;
    unsigned border = 0;  // its 4 lowest bits: neighbouring texels to extend into (IPR 3.2.1.1)
    int cluster = -1;     // -1: no probe supports it
};
struct BakedRay {
    int material = -1;      // -1: nothing was hit; -2: the back of a surface
    glm::vec2 uv{0};        // of the lightmap; where nothing was hit, of the environment
    glm::vec3 position{0};  // m
};
struct BakedCluster {
    std::vector<int> probes;  // that support it, in the order of the matrix
    int rank = 0;
    std::vector<float> sigma_vt;  // [rank][probes * coefficients]
    glm::vec3 low{0}, high{0};    // m: its box
};

struct BakeArrays {
    int rays = 0, coefficients = 0, singular_values = 32;
    std::vector<BakedReceiver> receivers;
    std::vector<float> u;           // [receivers][singular_values]
    std::vector<glm::vec3> probes;  // m
    std::vector<BakedRay> relight;  // [probes][rays]
    std::vector<float> sh;          // [rays][coefficients]: Y_j in the direction of ray i
    std::vector<BakedCluster> clusters;
};

struct TextureLayout {
    int clusters_in_row = 128, receivers_in_row = 128;
    int largest = 16384;  // texels of a side
};

struct TextureInfo {
    const char* name;
    const char* source;
    const char* vk_format;  // of a texel, without VK_FORMAT_
    DType dtype;
    int channels;
    const char* unit;
    const char* meaning;
};
// The eight in the thesis' order, then the four of IPR 3.2.5.9.
const std::vector<TextureInfo>& textures();

// One of them as [height][width][channels], the bytes of a GPU's image row by row. What is in no item is padding: -1 in
// integers, 0 in floats; a position has w = 1, padding 0. Throws InputError: an unknown name, arrays that do not fit
// each other, indices out of range, values that are not finite, a side longer than the layout allows.
Array texture(const std::string& name, const BakeArrays& arrays, const TextureLayout& layout = {});
Bundle all_textures(const BakeArrays& arrays, const TextureLayout& layout = {});

// Back, exactly; columns of the grids are those of the textures. differs: a rank is not stored, so that rows of zeros
// at the end of Sigma V^T are not part of it. Throws InputError where one is missing or says what no bake can, in a
// texel of padding, too.
BakeArrays arrays_of(const Bundle& textures);
// Of a whole bake.
BakeArrays arrays_of(const Bake& bake);

}  // namespace plumb::probes
