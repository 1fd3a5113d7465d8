// Integer hashes of (pixel, sample, seed): the twin of core/hash.h.
#ifndef PLUMB_HASH_GLSL
#define PLUMB_HASH_GLSL

uint pcg(uint value) {
    uint state = value * 747796405u + 2891336453u;
    uint word = ((state >> ((state >> 28) + 4u)) ^ state) * 277803737u;
    return (word >> 22) ^ word;
}

uvec3 pcg3d(uint x, uint y, uint z) {
    x = x * 1664525u + 1013904223u, y = y * 1664525u + 1013904223u, z = z * 1664525u + 1013904223u;
    x = x + y * z, y = y + z * x, z = z + x * y;
    x = x ^ (x >> 16), y = y ^ (y >> 16), z = z ^ (z >> 16);
    x = x + y * z, y = y + z * x, z = z + x * y;
    return uvec3(x, y, z);
}

uvec3 pixel_hash(uint pixel_x, uint pixel_y, uint sample_index, uint seed) {
    return pcg3d(pixel_x, pixel_y, pcg(sample_index + pcg(seed)));
}

float unit_float(uint hash) {
    precise float u = float(hash >> 8) * 5.9604644775390625e-8;  // 2^-24
    return u;
}

#endif
