// Materials and textures laid out for the kernels: records of floats and one buffer of texels. Built once a scene.
#pragma once

#include <cstdint>
#include <vector>

#include "core/image.h"
#include "core/scene.h"
#include "core/view.h"
#include "raster/layout.h"
#include "raster/surface_kernel.h"

namespace plumb::raster {

struct Surfaces {
    Buffer<float> materials;        // [material][16]: reflectance, alpha; emission (W/m2), alpha cutoff; rows of
                                    // `textures` (base, emission, normal; 0: none), scale of the normal; padding
    Buffer<std::int32_t> masked;    // [material]: 1 where the alpha cutoff is above 0
    bool any_masked = false;
    Buffer<std::int32_t> textures;  // [row][4]: first texel, width, height, flags (texture_kernel.h)
    Buffer<std::int32_t> texels;    // RGBA8, red in the lowest byte
    bool any_levels = false;        // whether any texture has levels of detail
    Buffer<float> decode;           // [2][256]: byte / 255, and the exact sRGB curve, each rounded once
    Brightest brightest;            // of what is drawn; 0 where nobody has said
    std::vector<std::int32_t> texture_rows;  // [texture of the scene]: its row of `textures`
    std::uint64_t textures_hash = 0;         // of the scene's textures, which rows and texels are made of
};

// Row 0 of `textures` is one white texel, for materials that have none. The scene's textures follow in their order,
// each with its smaller levels after it where it has mips (mips.h): without any, texture i is row i + 1. A normal map
// is dropped where the geometry has no tangents. Throws InputError for indices out of range and for textures without
// texels. Levels are copied from `before`, if any, where that was made of equal textures: making them costs most of all.
Surfaces prepare(const Scene& scene, const Geometry& geometry, const Surfaces* before = nullptr);

// [2][256], as above.
Buffer<float> decode_table();

// What the kernels read. The arguments must outlive the result. A frame of `size` pixels chooses levels of detail;
// without a size every texture is read at level 0.
SurfaceArgs surface_args(const Geometry& geometry, const Surfaces& surfaces, const View& view,
                         glm::ivec2 size = {0, 0});

}  // namespace plumb::raster
