#version 450
// Twin of bounce_kernel.h: what the next bounce gathers, B = B0 + rho E.
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform BounceUniforms {
    int width;
    int height;
    int receivers_width;
    int receivers_height;
    int margin;
    int reflected;  // 1: E has rho already
} u;
layout(binding = 1) uniform sampler2D radiosity_image;    // xyz B0, W/m2, w radiation mask
layout(binding = 2) uniform sampler2D reflectance_image;  // xyz rho
layout(binding = 3) uniform sampler2D gathered_image;     // xyz E, W/m2
layout(binding = 4, rgba32f) uniform writeonly image2D bounced_image;

vec4 bounce(ivec2 pixel) {
    vec4 b0 = texelFetch(radiosity_image, pixel, 0);              TAP(b0, b0.xyz);
    ivec2 at = pixel - ivec2(u.margin);
    bool inside = at.x >= 0 && at.x < u.receivers_width && at.y >= 0 && at.y < u.receivers_height;
    TAP(inside, inside);
    ivec2 fetched = inside ? at : ivec2(0);
    vec3 rho = u.reflected != 0 ? vec3(1.0) : texelFetch(reflectance_image, fetched, 0).xyz;
    TAP(rho, rho);
    vec3 e = texelFetch(gathered_image, fetched, 0).xyz;          TAP(irradiance, e);
    precise vec3 sent = vec3(b0.x + rho.x * e.x, b0.y + rho.y * e.y, b0.z + rho.z * e.z);
    vec3 b = inside ? sent : b0.xyz;                              TAP(radiosity, b);
    return vec4(b, b0.w);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    TAP_BEGIN(pixel, 0);
    imageStore(bounced_image, pixel, bounce(pixel));
}
