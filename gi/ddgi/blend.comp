#version 450
// Twin of blend_kernel.h: rays of a probe into its octahedral texels.
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"
#include "gi/ddgi/octahedral.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform BlendUniforms {
    int width;      // of the atlas, texels
    int height;
    int side;       // of a tile, without its gutter
    int columns;    // tiles of a row
    int probes;
    int rays;       // of each probe
    int moments;    // 1: of distance, 0: irradiance
    int sharpness;
    float hysteresis;
    float scale;
    float farthest;
    float least_weight;
} u;
layout(std430, binding = 1) readonly buffer Directions { vec4 directions[]; };
layout(std430, binding = 2) readonly buffer Hits { vec4 hits[]; };  // xyz radiance, W/(m2 sr); w distance, m
layout(binding = 3) uniform sampler2D previous;
layout(binding = 4, rgba32f) uniform writeonly image2D blended_image;

// x^n for x in [0, 1] and n >= 1, by squaring.
float whole_power(float x, int n) {
    precise float power = 1.0;
    precise float square = x;
    for (int left = n; left > 0; left >>= 1) {
        if ((left & 1) != 0) power = power * square;
        square = square * square;
    }
    return power;
}

vec4 blend(ivec2 pixel, int of_tile, ivec2 texel) {
    int probe = min(of_tile, u.probes - 1);                       TAP(probe, probe);
    vec3 d = direction_of(vec2(centre_of_texel(texel.x, u.side), centre_of_texel(texel.y, u.side)));
    TAP(direction, d);
    precise float total = 0.0;
    precise vec3 sum = vec3(0.0);
    for (int r = 0; r < u.rays; ++r) {
        TAP_SAMPLE(r);
        vec3 ray = directions[r].xyz;
        precise float cosine = max(0.0, d.x * ray.x + d.y * ray.y + d.z * ray.z);
        TAP(cosine, cosine);
        float power = whole_power(cosine, u.sharpness);
        float w = power >= u.least_weight ? power : 0.0;          TAP(w, w);
        vec4 hit = hits[probe * u.rays + r];
        float m = min(hit.w, u.farthest);
        precise vec3 value = u.moments != 0 ? vec3(m, m * m, 0.0) : hit.xyz;
        TAP(value, value);
        sum.x = sum.x + w * value.x;
        sum.y = sum.y + w * value.y;
        sum.z = sum.z + w * value.z;
        total = total + w;                                        TAP(total, total);
    }
    TAP_SAMPLE(-1);
    bool found = total > 0.0;
    precise float factor = u.scale / (found ? total : 1.0);
    precise vec3 mean = vec3(sum.x * factor, sum.y * factor, sum.z * factor);
    TAP(mean, mean);
    vec3 before = texelFetch(previous, pixel, 0).xyz;
    precise float taken = 1.0 - u.hysteresis;
    precise vec3 blended = vec3(taken * mean.x + u.hysteresis * before.x, taken * mean.y + u.hysteresis * before.y,
                                taken * mean.z + u.hysteresis * before.z);
    vec3 kept = found ? blended : before;                         TAP(texel, kept);
    return vec4(kept, 0.0);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    TAP_BEGIN(pixel, 0);
    ivec2 tile = pixel / (u.side + 2);
    ivec2 texel = pixel - tile * (u.side + 2);
    int of_tile = tile.y * u.columns + tile.x;
    bool gutter = texel.x < 1 || texel.y < 1 || texel.x > u.side || texel.y > u.side;
    if (gutter || tile.x >= u.columns || of_tile >= u.probes) return;
    imageStore(blended_image, pixel, blend(pixel, of_tile, texel));
}
