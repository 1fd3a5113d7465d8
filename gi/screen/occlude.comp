#version 450
// Twin of occlude_kernel.h: ambient occlusion over light from everywhere.
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform OccludeUniforms {
    vec4 ambient;  // xyz: irradiance from everywhere, W/m2
    int width;
    int height;
} u;
layout(binding = 1) uniform sampler2D indirect_image;  // xyz W/m2; w goes through
layout(binding = 2) uniform sampler2D open_image;      // x open share; w 1 on a surface
layout(binding = 3, rgba32f) uniform writeonly image2D occluded_image;

vec4 occlude(ivec2 pixel) {
    vec4 e = texelFetch(indirect_image, pixel, 0);                TAP(indirect, e.xyz);
    vec4 open = texelFetch(open_image, pixel, 0);                 TAP(open, open.x);
    precise vec3 lit = open.x * (e.xyz + u.ambient.xyz);
    vec3 result = open.w > 0.0 ? lit : vec3(0.0);                 TAP(occluded, result);
    return vec4(result, e.w);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    TAP_BEGIN(pixel, 0);
    imageStore(occluded_image, pixel, occlude(pixel));
}
