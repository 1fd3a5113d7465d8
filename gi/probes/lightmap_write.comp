#version 450
// Twin of lightmap_write_kernel.h: irradiance of receivers into the levels of the lightmap, borders extended.
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform LightmapUniforms {
    int width;   // of the strip of levels
    int height;
    int places;
} u;
layout(std430, binding = 1) readonly buffer Cover { int cover[]; };  // place of the receiver; -2 ring 1, -3 ring 2, else nothing
layout(std430, binding = 2) readonly buffer Irradiance { vec4 irradiance[]; };
layout(binding = 3, rgba32f) uniform writeonly image2D lightmap_image;

int cover_at(ivec2 at) {
    bool inside = at.x >= 0 && at.x < u.width && at.y >= 0 && at.y < u.height;
    return inside ? cover[at.y * u.width + at.x] : -1;
}

vec3 irradiance_at(int place) {
    bool there = place >= 0 && place < u.places;
    return there ? irradiance[place].xyz : vec3(0.0);
}

vec3 mean(vec3 sum, float count) {
    precise float n = max(count, 1.0);
    precise vec3 m = vec3(sum.x / n, sum.y / n, sum.z / n);
    return m;
}

vec3 mean_of_receivers(ivec2 at) {
    precise vec3 sum = vec3(0.0);
    precise float count = 0.0;
    for (int k = 0; k < 9; ++k) {
        int place = cover_at(at + ivec2(k % 3 - 1, k / 3 - 1));
        if (place >= 0 && place < u.places) {
            sum = sum + irradiance_at(place);
            count = count + 1.0;
        }
    }
    return mean(sum, count);
}

vec4 lightmap(ivec2 at) {
    int own = cover_at(at);                                       TAP(cover, own);
    vec3 value = irradiance_at(own);                              TAP(irradiance, value);
    bool ring_1 = own == -2;
    bool ring_2 = own == -3;
    if (ring_1) {
        value = mean_of_receivers(at);                            TAP(ring_1, value);
    }
    if (ring_2) {
        precise vec3 sum = vec3(0.0);
        precise float count = 0.0;
        for (int k = 0; k < 9; ++k) {
            ivec2 beside = at + ivec2(k % 3 - 1, k / 3 - 1);
            if (cover_at(beside) == -2) {
                sum = sum + mean_of_receivers(beside);
                count = count + 1.0;
            }
        }
        value = mean(sum, count);                                 TAP(ring_2, value);
    }
    TAP(lightmap, value);
    bool covered = (own >= 0 && own < u.places) || ring_1 || ring_2;
    return vec4(value, covered ? 1.0 : 0.0);
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (at.x >= u.width || at.y >= u.height) return;
    TAP_BEGIN(at, 0);
    imageStore(lightmap_image, at, lightmap(at));
}
