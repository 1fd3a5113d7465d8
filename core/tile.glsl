// The order in which a square tile of pixels deals something out: the twin of core/tile.h.
#ifndef PLUMB_TILE_GLSL
#define PLUMB_TILE_GLSL

// Where a pixel stands in that order, 0 to tile^2 - 1: Bayer's matrix.
int tile_place(int tile, ivec2 p) {
    int across = p.x ^ p.y;
    int place = 0;
    for (int bit = 1; bit < tile; bit *= 2) {
        int of_across = (across & bit) == 0 ? 0 : 2, of_row = (p.y & bit) == 0 ? 0 : 1;
        place = (place << 2) + of_across + of_row;
    }
    return place;
}

#endif
