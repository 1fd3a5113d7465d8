#version 450
// Twin of downsample_kernel.h: the buffers of a quarter of the pixels, ISR Listing 3.
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform DownsampleUniforms {
    int width;
    int height;
    int full_width;
    int full_height;
    int what;  // 0 surface, 1 radiosity, 2 reflectance
    int published;
    int clip_depth;
    float depth_slope;
    float depth_offset;
    int native;  // 1: a coarse pixel is one of the full image
} u;
layout(binding = 1) uniform sampler2D position_image;  // w: linear eye depth, m
layout(binding = 2) uniform sampler2D normal_image;    // xyz unit, w 1
layout(binding = 3) uniform sampler2D albedo_image;    // rho, w: radiation mask
layout(binding = 4) uniform sampler2D emission_image;  // W/m2
layout(binding = 5) uniform sampler2D direct_image;    // irradiance, W/m2
layout(binding = 6, rgba32f) uniform writeonly image2D coarse_image;

vec4 reflectance_of(ivec2 texel) {
    vec4 rho = texelFetch(albedo_image, texel, 0);
    precise float luminance = 0.27 * rho.x + 0.67 * rho.y + 0.06 * rho.z;
    return vec4(rho.xyz, rho.w > 0.0 ? rho.w : luminance);
}

vec4 value_of(ivec2 texel, vec4 normal) {
    if (u.what == 0) return vec4(normal.xyz, texelFetch(position_image, texel, 0).w);
    vec4 rho = reflectance_of(texel);
    if (u.what == 2) return vec4(rho.xyz, 0.0);
    if (u.published != 0) return rho;
    vec4 m = texelFetch(emission_image, texel, 0), e = texelFetch(direct_image, texel, 0);
    precise vec3 b = vec3(m.x + rho.x * e.x, m.y + rho.y * e.y, m.z + rho.z * e.z);
    return vec4(b, rho.w);
}

vec3 unit_or(vec3 sum, vec3 first) {
    precise float length2 = sum.x * sum.x + sum.y * sum.y + sum.z * sum.z;
    bool cancel = length2 < 1e-6;
    float size = sqrt(cancel ? 1.0 : length2);
    precise vec3 unit = vec3(sum.x / size, sum.y / size, sum.z / size);
    return cancel ? first : unit;
}

vec4 downsample(ivec2 pixel) {
    precise vec4 sum = vec4(0.0);
    vec3 first = vec3(0.0);
    precise float total = 0.0;
    for (int k = 0; k < (u.native != 0 ? 1 : 4); ++k) {
        TAP_SAMPLE(k);
        ivec2 at = u.native != 0 ? pixel : pixel + pixel + ivec2(k & 1, k >> 1);
        bool inside = at.x >= 0 && at.x < u.full_width && at.y >= 0 && at.y < u.full_height;
        ivec2 texel = ivec2(min(at.x, u.full_width - 1), min(at.y, u.full_height - 1));
        vec4 normal = texelFetch(normal_image, texel, 0);         TAP(normal, normal.xyz);
        bool covered = inside && normal.w > 0.0;                  TAP(covered, covered);
        vec4 value = value_of(texel, normal);                     TAP(value, value.xyz);
        TAP(value_w, value.w);
        // A mean of four (published) counts what is not there as a GPU reads it: the border again, and background.
        float weight = u.published != 0 ? 1.0 : (covered ? 1.0 : 0.0);
        bool counted = weight > 0.0;
        if (counted && total == 0.0) first = normal.xyz;
        vec4 term = vec4(counted ? value.x : 0.0, counted ? value.y : 0.0, counted ? value.z : 0.0,
                         counted ? value.w : 0.0);
        // Drivers take 0 + -0 for -0: the sum does not begin with 0.
        precise vec4 added = sum + term;
        sum = k == 0 ? term : added;
        total += weight;                                          TAP(total, total);
    }
    TAP_SAMPLE(-1);
    float divisor = max(total, 1.0);
    precise vec3 mean = vec3(sum.x / divisor, sum.y / divisor, sum.z / divisor);
    precise float w = sum.w / divisor;
    if (u.what == 0) {
        if (u.published == 0) mean = unit_or(sum.xyz, first);
        // 1e-30 m: nothing is divided by 0.
        precise float clip = u.depth_slope + u.depth_offset / max(w, 1e-30);
        if (u.clip_depth != 0) w = total > 0.0 ? clip : 0.0;
    }
    TAP(mean, mean);
    TAP(mean_w, w);
    return vec4(mean, w);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    TAP_BEGIN(pixel, 0);
    imageStore(coarse_image, pixel, downsample(pixel));
}
