#version 450
// Twin of lambda_kernel.h: what a probe sees, as coefficients of harmonics.
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform LambdaUniforms {
    int width;   // coefficients
    int height;  // probes
    int rays;    // of each probe at level 0
    int levels;  // of detail
    int rays_0;  // of each level: the first
    int rays_1;
    int rays_2;
    int rays_3;
    int coefficients_0;
    int coefficients_1;
    int coefficients_2;
    int coefficients_3;
} u;
layout(std430, binding = 1) readonly buffer Radiance { vec4 radiance[]; };  // W/(m2 sr)
layout(std430, binding = 2) readonly buffer Harmonics { float harmonics[]; };
layout(std430, binding = 3) readonly buffer Weights { float weights[]; };  // sr
layout(std430, binding = 4) readonly buffer ProbeLevel { int probe_level[]; };
layout(std430, binding = 5) writeonly buffer Lambda { vec4 lambda[]; };

// Of four numbers that of a level.
int of_level(int level, int a, int b, int c, int d) { return level < 2 ? (level < 1 ? a : b) : (level < 3 ? c : d); }

vec4 coefficient(int j, int probe) {
    int level = max(0, min(probe_level[probe], u.levels - 1));    TAP(level, level);
    int coefficients = of_level(level, u.coefficients_0, u.coefficients_1, u.coefficients_2, u.coefficients_3);
    TAP(coefficients, coefficients);
    int all = min(of_level(level, u.rays_0, u.rays_1, u.rays_2, u.rays_3), u.rays);
    int rays = j < coefficients ? all : 0;                        TAP(rays, rays);
    precise vec3 sum = vec3(0.0);
    for (int first = 0; first < rays; first += 128) {
        precise vec3 part = vec3(0.0);
        int end = min(first + 128, rays);
        for (int r = first; r < end; ++r) {
            TAP_SAMPLE(r);
            float w = weights[level * u.rays + r];                TAP(w, w);
            vec3 f = radiance[probe * u.rays + r].xyz;            TAP(f, f);
            float y = harmonics[r * u.width + j];                 TAP(y, y);
            part = part + w * f * y;                              TAP(part, part);
        }
        sum = sum + part;
    }
    TAP_SAMPLE(-1);                                               TAP(lambda, sum);
    return vec4(sum, 0.0);
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (at.x >= u.width || at.y >= u.height) return;
    TAP_BEGIN(at, 0);
    lambda[at.y * u.width + at.x] = coefficient(at.x, at.y);
}
