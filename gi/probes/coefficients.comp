#version 450
// Twin of coefficients_kernel.h: how much of each harmonic of each supporting probe a receiver gathers.
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform CoefficientsUniforms {
    int width;   // receivers
    int height;  // slots x coefficients
    int rays;    // of each receiver
    int slots;   // supporting probes of a receiver
} u;
layout(std430, binding = 1) readonly buffer Rows { ivec4 rows[]; };             // slot, l, |m|, 1 where m < 0
layout(std430, binding = 2) readonly buffer Recurrence { float recurrence[]; };
layout(std430, binding = 3) readonly buffer Supporting { vec4 supporting[]; };  // xyz the probe, m; w its weight
layout(std430, binding = 4) readonly buffer Seen { vec4 seen[]; };              // xyz a point, w 1; or a direction, w 0
layout(std430, binding = 5) readonly buffer Visible { int visible[]; };
layout(std430, binding = 6) readonly buffer Shares { float shares[]; };
layout(std430, binding = 7) writeonly buffer Alpha { float alpha[]; };

#define SH_RECURRENCE recurrence
#include "core/sh.glsl"

vec3 direction_to(vec4 s, vec4 probe) {
    precise vec3 d = vec3(s.x - s.w * probe.x, s.y - s.w * probe.y, s.z - s.w * probe.z);
    precise float len = max(sqrt(d.x * d.x + d.y * d.y + d.z * d.z), 1e-18);
    TAP(distance, len);
    precise vec3 psi = vec3(d.x / len, d.y / len, d.z / len);
    return psi;
}

float coefficient(int receiver, int row) {
    ivec4 of = rows[row];
    int slot = max(0, min(of.x, u.slots - 1));                    TAP(slot, slot);
    int l = max(0, min(of.y, 7));                                 TAP(l, l);
    int m = max(0, min(of.z, l));                                 TAP(m, m);
    vec4 probe = supporting[slot * u.width + receiver];           TAP(probe, probe.xyz);
    TAP(w, probe.w);
    precise float sum = 0.0;
    for (int first = 0; first < u.rays; first += 128) {
        precise float part = 0.0;
        int end = min(first + 128, u.rays);
        for (int k = first; k < end; ++k) {
            TAP_SAMPLE(k);
            int at = k * u.width + receiver;
            bool sees = ((visible[at] >> slot) & 1) == 1;         TAP(V, sees);
            precise float weight = sees ? shares[at] * probe.w : 0.0;
            TAP(weight, weight);
            vec3 psi = direction_to(seen[at], probe);             TAP(psi, psi);
            part = add_harmonic(l, m, of.w == 1, psi, weight, part);
            TAP(part, part);
        }
        sum = sum + part;
    }
    TAP_SAMPLE(-1);                                               TAP(alpha, sum);
    return sum;
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (at.x >= u.width || at.y >= u.height) return;
    TAP_BEGIN(at, 0);
    alpha[at.y * u.width + at.x] = coefficient(at.x, at.y);
}
