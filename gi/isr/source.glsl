// What a sample of the gather is, as in gather_kernel.h. The block of the uniforms u is declared before.

struct Source {
    vec3 position;
    float area;
    vec3 normal;
    vec3 radiosity;
};

// No light is brighter than this, W/m2: infinity times a form factor of 0 would be no number.
const float brightest = 1e30;

Source source_of(SampleUniforms of, ivec2 pixel, vec4 texel, vec3 radiosity) {
    Surface s = surface_of(of, pixel, texel);
    vec3 bounded = vec3(min(radiosity.x, brightest), min(radiosity.y, brightest), min(radiosity.z, brightest));
    return Source(s.position, area_of(of, s), s.normal, is_covered(s) ? bounded : vec3(0.0));
}

int rotation_of(ivec2 pixel) {
    return int(pixel_hash(uint(pixel.x), uint(pixel.y), 0u, u.seed).x >> 16) & (u.rotations - 1);
}
