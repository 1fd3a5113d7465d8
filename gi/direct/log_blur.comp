#version 450
// Twin of log_blur_kernel.h: the logarithmic blur of a light's depth map, along rows or columns (ISR 4.6).
#extension GL_GOOGLE_include_directive : require
#include "core/detmath.glsl"
#include "core/tap.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform LogBlurUniforms {
    int width;
    int height;
    int radius;
    int vertical;  // 0: along rows, 1: along columns
    float c;
} u;
layout(binding = 1) uniform sampler2D depth_map;  // w: linear depth, m; 0 where nothing is
layout(std430, binding = 2) readonly buffer Spatial { float spatial[]; };  // [2 radius + 1]
layout(binding = 3, rgba32f) uniform writeonly image2D blurred_image;

// What the map holds k - radius texels further along the row or the column; the border's texel stands in for what lies
// beyond it.
float stored_depth(ivec2 pixel, int k) {
    int along = k - u.radius;
    int x = u.vertical != 0 ? pixel.x : min(max(pixel.x + along, 0), u.width - 1);
    int y = u.vertical != 0 ? min(max(pixel.y + along, 0), u.height - 1) : pixel.y;
    return texelFetch(depth_map, ivec2(x, y), 0).w;
}

// log(1 + m) for -1/4 <= m <= 0: 2 artanh(s), s = m / (2 + m), |s| <= 1/7; to 2^-31.
float log_near_one(float m) {
    precise float s = m / (2.0 + m);
    precise float t = s * s;
    precise float tail = t * (0.333333343 + t * (0.2 + t * (0.142857149 + t * 0.111111112)));
    precise float result = (s + s * tail) * 2.0;
    return result;
}

vec4 log_blur(ivec2 pixel) {
    int last = u.radius + u.radius;

    // Find the deepest texel, and the nearest.
    float d_ref = 0.0;
    float nearest = 3e38;
    for (int k = 0; k <= last; ++k) {
        float d_i = stored_depth(pixel, k);
        d_ref = max(d_ref, d_i);
        nearest = min(nearest, d_i > 0.0 ? d_i : nearest);
    }
    TAP(d_ref, d_ref);

    precise float sum = 0.0;
    precise float less = 0.0;
    precise float total = 0.0;
    for (int k = 0; k <= last; ++k) {
        TAP_SAMPLE(k);
        float d_i = stored_depth(pixel, k);                     TAP(d_i, d_i);
        precise float exponent = u.c * (d_i - d_ref);           TAP(exponent, exponent);
        float weight = d_i > 0.0 ? spatial[k] : 0.0;            TAP(weight, weight);
        sum += weight * det_exp(exponent);                      TAP(sum, sum);
        less += weight * det_expm1(exponent);
        total += weight;
    }
    TAP_SAMPLE(-1);
    float divisor = max(total, 7.88860905e-31);                 // of at least one weight, or of none
    precise float mean = sum / divisor;                         TAP(mean, mean);
    precise float mean_less = less / divisor;                     TAP(mean_less, mean_less);
    precise float logarithm = mean_less >= -0.25 ? log_near_one(mean_less) : det_log(mean);
    // Rounding leads to no depth that is not between those of the taps.
    precise float d = max(nearest, d_ref + logarithm / u.c);
    float depth = d_ref > 0.0 ? d : 0.0;                         TAP(depth, depth);
    return vec4(0.0, 0.0, 0.0, depth);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    TAP_BEGIN(pixel, 0);
    imageStore(blurred_image, pixel, log_blur(pixel));
}
