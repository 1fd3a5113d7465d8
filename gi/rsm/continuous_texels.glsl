// Twin of texels_kernel.h, ContinuousTexels: each sample's own position is computed, and its texel holds it.
layout(std430, binding = 6) readonly buffer Positions { vec2 positions[]; };  // [samples][rotations]

#define CENTRE vec2

vec2 centre_of(Projection map, vec3 x) { return projected(map, x); }

// `reach` is a texel more than any offset.
bool is_near(vec2 centre, int map_size, int reach) {
    float low = float(-reach), high = float(map_size + reach);
    return centre.x >= low && centre.x < high && centre.y >= low && centre.y < high;
}

float within(vec2 centre, Projection map) {
    precise vec2 from_low = centre - map.low, to_high = map.high - centre;
    vec2 left = min(from_low, to_high);
    return min(left.x, left.y);
}

ivec2 texel_of(vec2 centre, int row) {
    precise vec2 place = centre + positions[row];               TAP(place, place);
    CHOICE(int(floor(place.x)));
    CHOICE(int(floor(place.y)));
    return ivec2(floor(place));
}
