#version 450
// Twin of density_kernel.h: how densely candidates for probes lie around each of them.
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"
#include "gi/probes/weight.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform DensityUniforms {
    int width;
    int height;
    int count;
    float inverse_radius;
} u;
layout(std430, binding = 1) readonly buffer Positions { vec4 positions[]; };
layout(std430, binding = 2) writeonly buffer Density { float density[]; };

float density_term(vec3 p, int i, int j) {
    precise float t = sqrt(distance2(positions[j].xyz, p)) * u.inverse_radius;
    bool counts = t < 1.0 && i != j;
    return counts ? spatial_weight(t) : 0.0;
}

float density_at(int i) {
    vec3 p = positions[i].xyz;                                    TAP(position, p);
    precise float sum = 0.0;
    for (int first = 0; first < u.count; first += 64) {
        precise float part = 0.0;
        int end = min(first + 64, u.count);
        for (int j = first; j < end; ++j) {
            TAP_SAMPLE(j);
            float w = density_term(p, i, j);                      TAP(w, w);
            part = part + w;
        }
        sum = sum + part;
    }
    TAP_SAMPLE(-1);
    TAP(density, sum);
    return sum;
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    int i = at.y * u.width + at.x;
    if (at.x >= u.width || at.y >= u.height || i >= u.count) return;
    TAP_BEGIN(at, 0);
    density[i] = density_at(i);
}
