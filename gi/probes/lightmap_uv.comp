#version 450
// Twin of lightmap_uv_kernel.h: where on the lightmap a pixel's surface lies.
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"
#include "gi/probes/level.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform LightmapUvUniforms {
    int width;
    int height;
    int triangles;  // that id counts
    int charted;    // that have a place on the lightmap
    int levels;     // of detail, 1: none
    vec4 eye;
    vec4 forward;
    vec4 zones;
    vec4 scales;
    vec4 distances;
    vec4 widths;
} u;
layout(binding = 1) uniform sampler2D position_image;                           // xyz m
layout(std430, binding = 2) readonly buffer Id { ivec2 id[]; };                 // object, triangle
layout(std430, binding = 3) readonly buffer ChartedOf { int charted_of[]; };
layout(std430, binding = 4) readonly buffer Corners { vec4 corners[]; };        // A, B, C with their u in w; their v
layout(binding = 5, rgba32f) uniform writeonly image2D uv_image;

float dot_of(vec3 a, vec3 b) {
    precise float d = a.x * b.x + a.y * b.y + a.z * b.z;
    return d;
}

vec3 cross_of(vec3 a, vec3 b) {
    precise vec3 c = vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
    return c;
}

vec4 lightmap_uv(ivec2 at) {
    int pixel = at.y * u.width + at.x;
    int triangle = id[pixel].y;
    int charted = charted_of[max(0, min(triangle, u.triangles - 1))];
    bool has = triangle >= 0 && triangle < u.triangles && charted >= 0 && charted < u.charted;
    TAP(triangle, triangle);
    TAP(charted, charted);
    int first = max(0, min(charted, u.charted - 1)) * 4;
    vec4 a = corners[first];
    vec4 b = corners[first + 1];
    vec4 c = corners[first + 2];
    vec4 v = corners[first + 3];
    vec4 p = texelFetch(position_image, at, 0);
    precise vec3 e1 = vec3(b.x - a.x, b.y - a.y, b.z - a.z);
    precise vec3 e2 = vec3(c.x - a.x, c.y - a.y, c.z - a.z);
    precise vec3 d = vec3(p.x - a.x, p.y - a.y, p.z - a.z);
    vec3 n = cross_of(e1, e2);
    float area = dot_of(n, n);                                    TAP(area, area);
    precise float scale = 1.0 / (area > 0.0 ? area : 1.0);
    precise float beta = max(0.0, min(dot_of(cross_of(d, e2), n) * scale, 1.0));
    precise float gamma = max(0.0, min(dot_of(cross_of(e1, d), n) * scale, 1.0 - beta));
    TAP(beta, beta);
    TAP(gamma, gamma);
    precise float x = a.w + beta * (b.w - a.w) + gamma * (c.w - a.w);
    precise float y = v.x + beta * (v.y - v.x) + gamma * (v.z - v.x);
    float distance = point_distance(p.xyz, u.eye.xyz, u.forward.xyz, u.zones, u.scales);
    TAP(distance, distance);
    int level = level_of(vec3(distance), u.distances, u.levels);
    float share = blend_of(distance, level, u.distances, u.widths, u.levels);
    TAP(level, level);
    TAP(share, share);
    precise float z = float(level) + share;
    vec4 uv = vec4(has ? x : -1.0, has ? y : -1.0, has ? z : 0.0, has ? 1.0 : 0.0);
    TAP(uv, uv.xyz);
    return uv;
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (at.x >= u.width || at.y >= u.height) return;
    TAP_BEGIN(at, 0);
    imageStore(uv_image, at, lightmap_uv(at));
}
