#version 450
// Twin of share_kernel.h: what a ray of a receiver counts for.
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform ShareUniforms {
    int width;      // receivers
    int height;     // rays of each
    int slots;      // supporting probes of a receiver
    int published;  // 1: weighted by the ray's length
} u;
layout(std430, binding = 1) readonly buffer Supporting { vec4 supporting[]; };  // xyz the probe, m; w its weight
layout(std430, binding = 2) readonly buffer Factors { float factors[]; };
layout(std430, binding = 3) readonly buffer Visible { int visible[]; };
layout(std430, binding = 4) readonly buffer Lengths { float lengths[]; };
layout(std430, binding = 5) writeonly buffer Share { float share[]; };

float share_of(int receiver, int ray) {
    int at = ray * u.width + receiver;
    int seen_by = visible[at];                                    TAP(visible, seen_by);
    precise float sum = 0.0;
    for (int slot = 0; slot < u.slots; ++slot) {
        TAP_SAMPLE(slot);
        float w = supporting[slot * u.width + receiver].w;        TAP(w, w);
        sum = sum + (((seen_by >> slot) & 1) == 1 ? w : 0.0);
    }
    TAP_SAMPLE(-1);                                               TAP(sum, sum);
    float x = lengths[at];                                        TAP(length, x);
    precise float t = 6.28318531 * x * x;
    precise float w_x = t / (t + 1.0);                            TAP(W, w_x);
    precise float factor = factors[ray] * (u.published == 1 ? w_x : 1.0);
    TAP(factor, factor);
    bool seen = sum > 0.0;
    precise float counted = seen ? factor / (seen ? sum : 1.0) : 0.0;
    TAP(share, counted);
    return counted;
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (at.x >= u.width || at.y >= u.height) return;
    TAP_BEGIN(at, 0);
    share[at.y * u.width + at.x] = share_of(at.x, at.y);
}
