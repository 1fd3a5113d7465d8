#version 450
// Twin of gather_kernel.h: irradiance of elements by rows of form factors.
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform GatherUniforms {
    int width;
    int height;
    int count;     // elements of the block
    int elements;  // of the scene
} u;
layout(std430, binding = 1) readonly buffer RowList { ivec4 rows[]; };        // first run, runs, first weight, weights
layout(std430, binding = 2) readonly buffer RunList { ivec2 runs[]; };        // first element, elements
layout(std430, binding = 3) readonly buffer Weights { float weights[]; };
layout(std430, binding = 4) readonly buffer Scale { float scale[]; };
layout(std430, binding = 5) readonly buffer Own { vec4 own[]; };
layout(std430, binding = 6) readonly buffer Radiosity { vec4 radiosity[]; };
layout(std430, binding = 7) writeonly buffer Irradiance { vec4 irradiance[]; };

// The sixteen sums of a row.
vec3 lane[16];

vec4 gathered(ivec2 at) {
    int i = min(at.y * u.width + at.x, u.count - 1);
    ivec4 row = rows[i];
    TAP(runs, row.y);
    for (int k = 0; k < 16; ++k) lane[k] = vec3(0.0);
    int next = row.z;
    for (int r = 0; r < row.y; ++r) {
        TAP_SAMPLE(r);
        ivec2 run = runs[row.x + r];
        TAP(first, run.x);
        TAP(count, run.y);
        for (int k = 0; k < run.y; ++k) {
            if (run.x + k < 0 || run.x + k >= u.elements) continue;
            float f = weights[next + k];
            vec3 b = radiosity[run.x + k].xyz;
            precise vec3 value = lane[k & 15] + f * b;
            lane[k & 15] = value;
        }
        next += run.y;
    }
    TAP_SAMPLE(-1);
    for (int n = 8; n > 0; n /= 2)
        for (int k = 0; k < n; ++k) {
            precise vec3 value = lane[k] + lane[k + n];
            lane[k] = value;
        }
    vec3 sum = lane[0];
    TAP(sum, sum);
    TAP(scale, scale[i]);
    TAP(own, own[i].xyz);
    precise vec3 h = own[i].xyz + scale[i] * sum;
    TAP(irradiance, h);
    return vec4(h, 0.0);
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (at.x >= u.width || at.y >= u.height || at.y * u.width + at.x >= u.count) return;
    TAP_BEGIN(at, 0);
    irradiance[at.y * u.width + at.x] = gathered(at);
}
