#version 450
// Twin of lookup_kernel.h: irradiance of a pixel from that of elements.
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform LookupUniforms {
    int width;
    int height;
    int triangles;
    int elements;
} u;
layout(binding = 1) uniform sampler2D position_image;
layout(std430, binding = 2) readonly buffer Id { ivec2 id[]; };  // object, triangle; -1, -1: nothing
layout(std430, binding = 3) readonly buffer Corners { vec4 corners[]; };
layout(std430, binding = 4) readonly buffer ElementOf { ivec4 of[]; };
layout(std430, binding = 5) readonly buffer Own { vec4 own[]; };  // irradiance of elements
layout(binding = 6, rgba32f) uniform writeonly image2D irradiance_image;

vec3 minus(vec3 a, vec3 b) {
    precise vec3 d = a - b;
    return d;
}
vec3 cross_of(vec3 a, vec3 b) {
    precise vec3 c = vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
    return c;
}
float dot_of(vec3 a, vec3 b) {
    precise float sum = a.x * b.x + a.y * b.y + a.z * b.z;
    return sum;
}
float length2(vec3 v) { return dot_of(v, v); }
bool in_range(int i, int n) { return i >= 0 && i < n; }

vec4 lookup(ivec2 pixel) {
    int triangle = id[pixel.y * u.width + pixel.x].y;
    TAP(triangle, triangle);
    bool has = in_range(triangle, u.triangles);
    int t = has ? triangle : 0;
    vec3 c0 = corners[3 * t].xyz;
    vec3 c1 = corners[3 * t + 1].xyz;
    vec3 c2 = corners[3 * t + 2].xyz;
    precise float short_edge = length2(minus(c2, c1)) * 7.0;
    bool next = short_edge < length2(minus(c1, c0)) && short_edge < length2(minus(c0, c2));
    TAP(next, next ? 1.0 : 0.0);
    vec3 a = next ? c1 : c0;
    vec3 p = texelFetch(position_image, pixel, 0).xyz;
    vec3 e1 = minus(next ? c2 : c1, a);
    vec3 e2 = minus(next ? c0 : c2, a);
    vec3 d = minus(p, a);
    vec3 n = cross_of(e1, e2);
    float area = dot_of(n, n);
    TAP(area, area);
    precise float scale = 1.0 / (area > 0.0 ? area : 1.0);
    precise float across = dot_of(cross_of(d, e2), n) * scale;
    precise float beta = max(0.0, min(across, 1.0));
    precise float along = dot_of(cross_of(e1, d), n) * scale;
    precise float gamma = max(0.0, min(along, 1.0 - beta));
    TAP(beta, beta);
    TAP(gamma, gamma);
    vec3 h[3];
    bool known = has;
    for (int k = 0; k < 3; ++k) {
        int element = of[t][k];
        known = known && in_range(element, u.elements);
        h[k] = own[in_range(element, u.elements) ? element : 0].xyz;
        TAP(corner, h[k]);
    }
    vec3 from = next ? h[1] : h[0];
    vec3 second = next ? h[2] : h[1];
    vec3 third = next ? h[0] : h[2];
    precise vec3 mixed = from + (minus(second, from) * beta + minus(third, from) * gamma);
    vec4 irradiance = vec4(known ? mixed.x : 0.0, known ? mixed.y : 0.0, known ? mixed.z : 0.0, 0.0);
    TAP(irradiance, irradiance.xyz);
    return irradiance;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    TAP_BEGIN(pixel, 0);
    imageStore(irradiance_image, pixel, lookup(pixel));
}
