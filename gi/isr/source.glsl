// What a sample of the gather is, as in gather_kernel.h. The block of the uniforms u is declared before.

struct Source {
    vec3 to;
    float area;
    float weight;
    vec3 normal;
    vec3 radiosity;
};

// No light is brighter than this, W/m2: infinity times a form factor of 0 would be no number.
const float brightest = 1e30;

vec3 light_of(Surface s, vec3 radiosity) {
    vec3 bounded = vec3(min(radiosity.x, brightest), min(radiosity.y, brightest), min(radiosity.z, brightest));
    return is_covered(s) ? bounded : vec3(0.0);
}

// How far two rays lie apart at eye depth 1 m that are (dx, dy) pixels apart.
vec3 step_of(float dx, float dy) {
    precise vec3 step = vec3(u.right.x * dx + u.down.x * dy, u.right.y * dx + u.down.y * dy,
                             u.right.z * dx + u.down.z * dy);
    return step;
}

// X - P = r_X z_X - r_P z_P, as (r_X - r_P) z_X + r_P (z_X - z_P).
vec3 between(Surface p, vec3 step, float depth) {
    precise float further = depth - p.depth;
    precise vec3 d = vec3(step.x * depth + p.ray.x * further, step.y * depth + p.ray.y * further,
                          step.z * depth + p.ray.z * further);
    return d;
}

#include "gi/isr/rotation.glsl"
