#version 450
// Twin of compose_kernel.h: composition of direct and indirect light (ISR (29)).
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform ComposeUniforms {
    vec4 environment;  // xyz: radiance where no surface is, W/(m2 sr)
    vec4 ambient;      // xyz: irradiance of a point that nothing hides, W/m2
    float inv_pi;
    float k_ssao;
    float k_isr;
    int published;
    int width;
    int height;
    float light_unit;  // W/(m2 sr) of a colour of 1, read where published
    int occlusion;     // 1: (29) adds what is occluded, read where published
} u;
layout(binding = 1) uniform sampler2D normal_image;    // w: 1 on a surface, 0 where nothing is
layout(binding = 2) uniform sampler2D albedo_image;    // rho
layout(binding = 3) uniform sampler2D emission_image;  // radiant exitance M, W/m2
layout(binding = 4) uniform sampler2D direct_image;    // irradiance, W/m2
layout(binding = 5) uniform sampler2D indirect_image;  // xyz irradiance, W/m2, w accessibility
layout(binding = 6, rgba32f) uniform writeonly image2D radiance_image;

vec3 compose(ivec2 pixel) {
    bool covered = texelFetch(normal_image, pixel, 0).w > 0.0;
    vec3 rho = texelFetch(albedo_image, pixel, 0).xyz;          TAP(albedo, rho);
    vec3 exitance = texelFetch(emission_image, pixel, 0).xyz;   TAP(emission, exitance);
    vec3 direct = texelFetch(direct_image, pixel, 0).xyz;       TAP(direct, direct);
    vec4 lit = texelFetch(indirect_image, pixel, 0);
    vec3 indirect = lit.xyz;                                    TAP(indirect, indirect);
    float open = lit.w;                                         TAP(accessibility, open);

    precise float occluded = 1.0 - open;
    float term = u.published != 0 && u.occlusion != 0 ? occluded : open;
    precise float passes = min(max(term + 1.0 - u.k_ssao, 0.0), 1.0);  TAP(passes, passes);
    precise vec3 e = u.k_isr * indirect;
    precise vec3 radiance;
    if (u.published != 0) {
        precise vec3 added = u.light_unit * e;
        radiance = (rho * (direct * passes) + exitance) * u.inv_pi + added;
    } else {
        precise vec3 ambient = open * u.ambient.xyz;
        radiance = (rho * (direct * passes + e + ambient) + exitance) * u.inv_pi;
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
