#version 450
// Twin of irradiance_kernel.h: a cluster's basis vector, weighed by a receiver's row of U.
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform IrradianceUniforms {
    int width;     // of the domain: the list of places, folded to rows
    int height;
    int count;     // places
    int clusters;
    int singular_values;
} u;
layout(std430, binding = 1) readonly buffer Clusters { ivec4 clusters[]; };  // w the rank
layout(std430, binding = 2) readonly buffer ClusterLevel { int cluster_level[]; };
layout(std430, binding = 3) readonly buffer Cluster { int cluster[]; };      // of each place; -1: none
layout(std430, binding = 4) readonly buffer ReceiverLevel { int receiver_level[]; };
layout(std430, binding = 5) readonly buffer Transport { float transport[]; };  // U: [singular_values][count]
layout(std430, binding = 6) readonly buffer Basis { vec4 basis[]; };           // [clusters][singular_values]
layout(std430, binding = 7) writeonly buffer Irradiance { vec4 irradiance[]; };

vec4 irradiance_of(int place) {
    int own = cluster[place];                                     TAP(cluster, own);
    bool there = own >= 0 && own < u.clusters;
    int of = there ? own : 0;
    int level = receiver_level[place];                            TAP(level, level);
    bool computed = there && level >= cluster_level[of];          TAP(computed, computed);
    int rank = computed ? clusters[of].w : 0;
    precise vec3 sum = vec3(0.0);
    for (int s = 0; s < rank; ++s) {
        TAP_SAMPLE(s);
        float weight = transport[s * u.count + place];            TAP(u, weight);
        vec3 b = basis[of * u.singular_values + s].xyz;           TAP(b, b);
        sum.x = sum.x + weight * b.x;
        sum.y = sum.y + weight * b.y;
        sum.z = sum.z + weight * b.z;
    }
    TAP_SAMPLE(-1);                                               TAP(irradiance, sum);
    return vec4(sum, computed ? 1.0 : 0.0);
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    int place = at.y * u.width + at.x;
    if (at.x >= u.width || at.y >= u.height || place >= u.count) return;
    TAP_BEGIN(at, 0);
    irradiance[place] = irradiance_of(place);
}
