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

// Texels from the border of a map on which projections are held: 0 where one is, in a border texel.
float within(ivec2 centre, Projection map) {
    precise vec2 from_low = vec2(centre), to_high = float(map.size - 1) - from_low;
    vec2 left = min(from_low, to_high);
    return min(left.x, left.y);
}

ivec2 texel_of(ivec2 centre, int row) {
    int offset = offsets[row];
    return centre + ivec2((offset << 16) >> 16, offset >> 16);
}
