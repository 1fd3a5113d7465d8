#version 450
// Twin of reduce_kernel.h: a drawn hemicube, weighed and summed box by box.
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform ReduceUniforms {
    int width;     // of what is left
    int height;
    int across;    // texels of a box
    int down;
    int rows;      // of a hemicube, before
    int weighted;  // 1: the first pass
    float gain;
} u;
layout(std430, binding = 1) readonly buffer Texels { vec4 texels[]; };    // hemicubes, one below the other; w share of a front
layout(std430, binding = 2) readonly buffer Weights { float weights[]; };
layout(std430, binding = 3) writeonly buffer Sums { vec4 sums[]; };

vec4 reduced(ivec2 at) {
    int columns = u.width * u.across;
    int left = at.x * u.across;
    int top = at.y * u.down;
    int cube = top / u.rows;
    TAP(cube, cube);
    int own = top - cube * u.rows;
    vec4 sum = vec4(0.0);
    for (int j = 0; j < u.down; ++j)
        for (int i = 0; i < u.across; ++i) {
            TAP_SAMPLE(j * u.across + i);
            int x = left + i;
            vec4 b = texels[(top + j) * columns + x];
            TAP(texel, b.xyz);
            float w = 1.0;
            if (u.weighted != 0) w = weights[(own + j) * columns + x];
            TAP(weight, w);
            precise vec4 next = sum + w * b;
            sum = next;
        }
    TAP_SAMPLE(-1);
    precise vec4 result = u.gain * sum;
    TAP(sum, result.xyz);
    TAP(front, result.w);
    return result;
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (at.x >= u.width || at.y >= u.height) return;
    TAP_BEGIN(at, 0);
    sums[at.y * u.width + at.x] = reduced(at);
}
