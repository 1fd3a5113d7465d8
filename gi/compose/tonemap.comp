#version 450
// Twin of tonemap_kernel.h: radiance to the values of a display.
#extension GL_GOOGLE_include_directive : require
#include "core/detmath.glsl"
#include "core/tap.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform TonemapUniforms {
    int op;  // 0 clamp, 1 exposure, 2 reinhard, 3 filmic
    float exposure;
    int width;
    int height;
    float dimmer;
    float contrast;   // 1: left out
    float inv_gamma;  // 0: the curve of sRGB
} u;
layout(binding = 1) uniform sampler2D radiance_image;  // W/(m2 sr)
layout(binding = 2, rgba32f) uniform writeonly image2D display_image;

// A power about middle grey.
float contrasted(float value) {
    if (u.contrast == 1.0) return value;
    precise float x = min(max(value, 0.0), 1e10) * 5.55555534;
    precise float y = 0.18 * det_pow(x, u.contrast);
    precise float left = max(y - 7.88860905e-31, 0.0);  // 2^-100
    return left;
}

// Hable 2010.
float filmic_curve(float x) {
    precise float y = x * (0.14 * x + 0.0166666675) / (x * (0.15 * x + 0.5) + 0.06);
    return y;
}

float tone_curve(int op, float value) {
    precise float x = min(max(value, 0.0), 1e10);
    precise float y = min(x, 1.0);
    if (op == 1) y = -det_expm1(-x);
    if (op == 2) y = x / (1.0 + x);
    if (op == 3) y = filmic_curve(x + x) / filmic_curve(11.2);
    return y;
}

float srgb_encode(float value) {
    precise float c = min(max(value, 0.0), 1.0);
    precise float curve = 1.055 * det_pow(c, 0.416666657) - 0.055;
    precise float line = 12.92 * c;
    return c <= 0.0031308 ? line : min(curve, 1.0);
}

float encode(float value) {
    if (u.inv_gamma == 0.0) return srgb_encode(value);
    return min(det_pow(min(max(value, 0.0), 1.0), u.inv_gamma), 1.0);
}

vec3 tonemap(ivec2 pixel) {
    vec3 radiance = texelFetch(radiance_image, pixel, 0).xyz;   TAP(radiance, radiance);
    precise vec3 x = u.dimmer * (u.exposure * radiance);
    vec3 light = vec3(contrasted(x.x), contrasted(x.y), contrasted(x.z));
    TAP(light, light);
    vec3 mapped = vec3(tone_curve(u.op, light.x), tone_curve(u.op, light.y), tone_curve(u.op, light.z));
    TAP(mapped, mapped);
    vec3 display = vec3(encode(mapped.x), encode(mapped.y), encode(mapped.z));
    TAP(display, display);
    return display;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    TAP_BEGIN(pixel, 0);
    imageStore(display_image, pixel, vec4(tonemap(pixel), 1.0));
}
