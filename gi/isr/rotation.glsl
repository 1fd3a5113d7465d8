// Which rotation of the samples a pixel has, as in gather_kernel.h. The block of the uniforms u is declared before.

#include "core/tile.glsl"

int rotation_of(ivec2 pixel) {
    if (u.tile != 0) return tile_place(u.tile, pixel);
    return int(pixel_hash(uint(pixel.x), uint(pixel.y), 0u, u.seed).x >> 16) & (u.rotations - 1);
}
