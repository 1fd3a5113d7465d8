#version 450
// Twin of compose_kernel.h: what leaves a diffuse surface towards the viewer.
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform ComposeUniforms {
    vec4 environment;
    float inv_pi;
    int width;
    int height;
    int shadowed;       // 0: the shadow colour is black, and nothing is added
    vec4 shadow_color;  // xyz: radiance of a surface without direct light, W/(m2 sr)
} u;
layout(binding = 1) uniform sampler2D normal_image;    // w: 1 on a surface, 0 where nothing is
layout(binding = 2) uniform sampler2D albedo_image;    // rho
layout(binding = 3) uniform sampler2D emission_image;  // radiant exitance M, W/m2
layout(binding = 4) uniform sampler2D direct_image;    // irradiance, W/m2; w: shadow density
layout(binding = 5) uniform sampler2D indirect_image;  // irradiance, W/m2
layout(binding = 6, rgba32f) uniform writeonly image2D radiance_image;

vec3 compose(ivec2 pixel) {
    bool covered = texelFetch(normal_image, pixel, 0).w > 0.0;
    vec3 rho = texelFetch(albedo_image, pixel, 0).xyz;          TAP(albedo, rho);
    vec3 exitance = texelFetch(emission_image, pixel, 0).xyz;   TAP(emission, exitance);
    vec4 lit = texelFetch(direct_image, pixel, 0);
    vec3 direct = lit.xyz;                                      TAP(direct, direct);
    vec3 indirect = texelFetch(indirect_image, pixel, 0).xyz;   TAP(indirect, indirect);

    precise vec3 radiance = (rho * (direct + indirect) + exitance) * u.inv_pi;
    if (u.shadowed != 0) {
        precise float shadow = 1.0 - lit.w;                     TAP(shadow, shadow);
        radiance += shadow * u.shadow_color.xyz;
    }
    radiance = covered ? radiance : u.environment.xyz;          TAP(radiance, radiance);
    return radiance;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    TAP_BEGIN(pixel, 0);
    imageStore(radiance_image, pixel, vec4(compose(pixel), 0.0));
}
