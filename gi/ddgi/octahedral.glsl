// Directions on octahedral tiles, as in octahedral_kernel.h.

float sign_not_zero(float x) { return x < 0.0 ? -1.0 : 1.0; }

vec2 folded(vec2 e) {
    precise vec2 f = vec2((1.0 - abs(e.y)) * sign_not_zero(e.x), (1.0 - abs(e.x)) * sign_not_zero(e.y));
    return f;
}

// The point of [-1, 1]^2 of a direction of any length; of 0 the middle.
vec2 octahedral_of(vec3 d) {
    precise float len = max(abs(d.x) + abs(d.y) + abs(d.z), 1e-30);
    precise vec2 e = vec2(d.x / len, d.y / len);
    return d.z < 0.0 ? folded(e) : e;
}

// The unit direction of a point of [-1, 1]^2.
vec3 direction_of(vec2 e) {
    precise float z = 1.0 - abs(e.x) - abs(e.y);
    vec2 f = z < 0.0 ? folded(e) : e;
    precise float len = sqrt(f.x * f.x + f.y * f.y + z * z);
    precise vec3 d = vec3(f.x / len, f.y / len, z / len);
    return d;
}

// Where a point of the square lies in its tile, texels; and the point of a texel's centre.
float place_in_tile(float e, int side) {
    precise float middle = 0.5 * float(side);
    precise float place = e * middle + (middle + 0.5);
    return place;
}
float centre_of_texel(int texel, int side) {
    precise float middle = 0.5 * float(side);
    precise float e = (float(texel) - (middle + 0.5)) / middle;
    return e;
}
