// Which rotation of the samples a pixel has, as in gather_kernel.h. The block of the uniforms u is declared before.

// Where a pixel stands in the order in which a tile deals out rotations: Bayer's matrix.
int tile_place(int tile, ivec2 p) {
    int across = p.x ^ p.y;
    int place = 0;
    for (int bit = 1; bit < tile; bit *= 2) {
        int of_across = (across & bit) == 0 ? 0 : 2, of_row = (p.y & bit) == 0 ? 0 : 1;
        place = (place << 2) + of_across + of_row;
    }
    return place;
}

int rotation_of(ivec2 pixel) {
    if (u.tile != 0) return tile_place(u.tile, pixel);
    return int(pixel_hash(uint(pixel.x), uint(pixel.y), 0u, u.seed).x >> 16) & (u.rotations - 1);
}
