// Twin of texels_kernel.h, WholeTexels: samples are whole texels away from the projection of x, which alone is rounded.
layout(std430, binding = 6) readonly buffer Offsets { int offsets[]; };  // [samples][rotations]

#define CENTRE ivec2

ivec2 centre_of(Projection map, vec3 x) {
    ivec2 centre = project(map, x);                             TAP(centre, centre);
    return centre;
}

// Where no sample can meet the map there is nothing to sum.
bool is_near(ivec2 centre, int map_size, int reach) {
    ivec2 shifted = centre + reach;
    int range = map_size + 2 * reach;
    return shifted.x >= 0 && shifted.x < range && shifted.y >= 0 && shifted.y < range;
}

// Whether x lies where its projection says: one that is held on the map ends in a border texel.
bool is_in_place(ivec2 centre, Projection map) {
    if (map.low < 0.0) return true;
    int last = map.size - 2;
    return centre.x >= 1 && centre.x <= last && centre.y >= 1 && centre.y <= last;
}

ivec2 texel_of(ivec2 centre, int row) {
    int offset = offsets[row];
    return centre + ivec2((offset << 16) >> 16, offset >> 16);
}
