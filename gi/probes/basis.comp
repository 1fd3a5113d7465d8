#version 450
// Twin of basis_kernel.h: what the light at a cluster's probes amounts to.
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform BasisUniforms {
    int width;           // singular values
    int height;          // clusters
    int coefficients;    // of a probe
    int probes;
    int coefficients_0;  // that are used, by level of detail
    int coefficients_1;
    int coefficients_2;
    int coefficients_3;
} u;
layout(std430, binding = 1) readonly buffer Clusters { ivec4 clusters[]; };  // first number, first probe, probes, rank
layout(std430, binding = 2) readonly buffer ClusterProbes { int cluster_probes[]; };
layout(std430, binding = 3) readonly buffer ClusterLevel { int cluster_level[]; };
layout(std430, binding = 4) readonly buffer Matrix { float matrix[]; };      // of each cluster [probes x coefficients][rank]
layout(std430, binding = 5) readonly buffer Lambda { vec4 lambda[]; };       // [probes][coefficients]
layout(std430, binding = 6) writeonly buffer Basis { vec4 basis[]; };

int coefficients_used(int level) {
    int upper = level == 2 ? u.coefficients_2 : level == 3 ? u.coefficients_3 : 0;
    return level == 0 ? u.coefficients_0 : level == 1 ? u.coefficients_1 : upper;
}

vec4 basis_of(int s, int cluster) {
    ivec4 of = clusters[cluster];
    int used = coefficients_used(cluster_level[cluster]);
    TAP(rank, of.w);
    TAP(coefficients, used);
    int added = s < of.w ? min(of.z, u.probes) : 0;
    precise vec3 sum = vec3(0.0);
    for (int k = 0; k < added; ++k) {
        TAP_SAMPLE(k);
        int probe = cluster_probes[of.y + k];                     TAP(probe, probe);
        precise vec3 part = vec3(0.0);
        for (int j = 0; j < used; ++j) {
            float m = matrix[of.x + (k * u.coefficients + j) * of.w + s];
            vec3 l = lambda[probe * u.coefficients + j].xyz;
            part.x = part.x + m * l.x;
            part.y = part.y + m * l.y;
            part.z = part.z + m * l.z;
        }
        TAP(part, part);
        sum.x = sum.x + part.x;
        sum.y = sum.y + part.y;
        sum.z = sum.z + part.z;
    }
    TAP_SAMPLE(-1);                                               TAP(b, sum);
    return vec4(sum, 0.0);
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (at.x >= u.width || at.y >= u.height) return;
    TAP_BEGIN(at, 0);
    basis[at.y * u.width + at.x] = basis_of(at.x, at.y);
}
