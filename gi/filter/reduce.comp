#version 450
// Twin of reduce_kernel.h: one pixel of every 2 x 2.
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform ReduceUniforms {
    int width;
    int height;
    int full_width;
    int full_height;
} u;
layout(binding = 1) uniform sampler2D full_image;
layout(binding = 2, rgba32f) uniform writeonly image2D reduced_image;

vec4 reduce(ivec2 pixel) {
    ivec2 picked = min(pixel + pixel + 1, ivec2(u.full_width - 1, u.full_height - 1));
    TAP(picked, picked);
    vec4 value = texelFetch(full_image, picked, 0);             TAP(value, value.xyz);
    return value;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    TAP_BEGIN(pixel, 0);
    imageStore(reduced_image, pixel, reduce(pixel));
}
