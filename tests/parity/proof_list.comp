#version 450
// A stage over a list of receivers: what each gathers from the senders that it lists, into a buffer.
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform ListUniforms {
    int receivers;
    int senders;
    int links;      // of each receiver
    float scale;
} u;
layout(std430, binding = 1) readonly buffer Positions { vec4 positions[]; };
layout(std430, binding = 2) readonly buffer Links { int links[]; };
layout(std430, binding = 3) readonly buffer Radiosity { vec4 radiosity[]; };
layout(std430, binding = 4) writeonly buffer Gathered { vec4 gathered[]; };

vec4 gather(int receiver) {
    vec3 x = positions[receiver].xyz;
    precise vec3 sum = vec3(0.0);
    for (int k = 0; k < u.links; ++k) {
        int sender = links[receiver * u.links + k];               TAP_SAMPLE(k); TAP(sender, sender);
        vec4 b = radiosity[sender];
        precise float d = (x.x - b.w) * (x.x - b.w) + 1.0;        TAP(squared, d);
        precise float w = u.scale / d;
        sum = vec3(sum.x + w * b.x, sum.y + w * b.y, sum.z + w * b.z);
    }
    TAP_SAMPLE(-1);
    TAP(irradiance, sum);
    return vec4(sum, float(u.links));
}

void main() {
    int receiver = int(gl_GlobalInvocationID.x);
    if (receiver >= u.receivers || gl_GlobalInvocationID.y > 0u) return;
    TAP_BEGIN(ivec2(receiver, 0), 0);
    gathered[receiver] = gather(receiver);
}
