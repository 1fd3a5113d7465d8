#version 450
// Twin of gather_kernel.h, gather_all(): every texel of the map, without visibility.
#extension GL_GOOGLE_include_directive : require
#include "gi/rsm/gather_form.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform GatherUniformBlock { GatherUniforms u; };
layout(binding = 1) uniform sampler2D position_image;  // xyz world, m
layout(binding = 2) uniform sampler2D normal_image;    // xyz unit
layout(binding = 3) uniform sampler2D rsm_position;    // xyz world, m
layout(binding = 4) uniform sampler2D rsm_normal;      // xyz unit
layout(binding = 5) uniform sampler2D rsm_flux;        // xyz W
layout(binding = 6, rgba32f) uniform writeonly image2D irradiance_image;

vec3 gather_all(ivec2 pixel) {
    vec3 x = texelFetch(position_image, pixel, 0).xyz;          TAP(x, x);
    vec3 n = texelFetch(normal_image, pixel, 0).xyz;            TAP(n, n);

    precise vec3 sum = vec3(0.0);
    for (int row = 0; row < u.map.size; ++row) {
        precise vec3 row_sum = vec3(0.0);
        for (int column = 0; column < u.map.size; ++column) {
            ivec2 texel = ivec2(column, row);                       TAP_SAMPLE(row * u.map.size + column);
            vec3 x_p = texelFetch(rsm_position, texel, 0).xyz;  TAP(x_p, x_p);
            vec3 n_p = texelFetch(rsm_normal, texel, 0).xyz;    TAP(n_p, n_p);
            vec3 flux = texelFetch(rsm_flux, texel, 0).xyz;     TAP(flux, flux);
            precise float g = form(x, n, x_p, n_p, u.least_distance2);
            row_sum.x += flux.x * g;
            row_sum.y += flux.y * g;
            row_sum.z += flux.z * g;                            TAP(row_sum, row_sum);
        }
        sum.x += row_sum.x;
        sum.y += row_sum.y;
        sum.z += row_sum.z;                                     TAP(sum, sum);
    }
    TAP_SAMPLE(-1);
    precise vec3 irradiance = sum * u.scale;                   TAP(irradiance, irradiance);
    return irradiance;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    TAP_BEGIN(pixel, 0);
    imageStore(irradiance_image, pixel, vec4(gather_all(pixel), 0.0));
}
