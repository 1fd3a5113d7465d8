#version 450
// Twin of supports_kernel.h: the probes that support a receiver, the nearest first, and their weights.
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"
#include "gi/probes/weight.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform SupportsUniforms {
    int width;   // slots of a receiver
    int height;  // receivers
    int probes;
    float radius;
} u;
layout(std430, binding = 1) readonly buffer Receivers { vec4 receivers[]; };
layout(std430, binding = 2) readonly buffer Probes { vec4 probes[]; };
layout(std430, binding = 3) writeonly buffer SupportIndices { int support[]; };
layout(std430, binding = 4) writeonly buffer Weight { float weight[]; };

struct Support {
    int probe;  // -1: none
    float weight;
};

// The nearest probes, sorted; of equals the lower index is first.
float nearest_d2[16];
int nearest_probe[16];

void find_nearest(vec3 x) {
    int last = u.width - 1;
    precise float end = u.radius * u.radius;
    for (int k = 0; k <= last; ++k) nearest_d2[k] = end, nearest_probe[k] = -1;
    for (int j = 0; j < u.probes; ++j) {
        float d2 = distance2(probes[j].xyz, x);
        bool nearer = d2 < nearest_d2[last];
        if (!nearer) continue;
        for (int k = last; k > 0; --k) {
            bool passes = d2 < nearest_d2[k - 1];
            nearest_d2[k] = nearer ? (passes ? nearest_d2[k - 1] : d2) : nearest_d2[k];
            nearest_probe[k] = nearer ? (passes ? nearest_probe[k - 1] : j) : nearest_probe[k];
            nearer = passes;
        }
        nearest_d2[0] = nearer ? d2 : nearest_d2[0];
        nearest_probe[0] = nearer ? j : nearest_probe[0];
    }
}

Support support_of(int k) {
    precise float t = sqrt(nearest_d2[k]) / u.radius;
    return Support(nearest_probe[k], nearest_probe[k] > -1 ? spatial_weight(t) : 0.0);
}

Support support_at(int slot, int receiver) {
    vec3 x = receivers[receiver].xyz;
    TAP(receiver, x);
    find_nearest(x);
    Support own = Support(-1, 0.0);
    for (int k = 0; k < u.width; ++k) {
        TAP_SAMPLE(k);
        Support s = support_of(k);
        TAP(probe, s.probe);
        TAP(distance2, nearest_d2[k]);
        TAP(weight, s.weight);
        if (slot == k) own = s;
    }
    TAP_SAMPLE(-1);
    return own;
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (at.x >= u.width || at.y >= u.height) return;
    TAP_BEGIN(at, 0);
    Support s = support_at(at.x, at.y);
    support[at.y * u.width + at.x] = s.probe;
    weight[at.y * u.width + at.x] = s.weight;
}
