#version 450
// Twin of blur_kernel.h: the edge-aware blur of VRSM 4.5, full or one direction of the separable form.
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"
#include "gi/filter/weights.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform BlurUniforms {
    int width;
    int height;
    int radius_x;
    int radius_y;
    int similarity;  // 0 plane, 1 depth
    float sigma_depth;
    float normal_slope;
    float normal_offset;
} u;
layout(binding = 1) uniform sampler2D irradiance_image;  // xyz W/m2, w linear depth, m
layout(binding = 2) uniform sampler2D position_image;    // xyz world, m
layout(binding = 3) uniform sampler2D normal_image;      // xyz unit
layout(std430, binding = 4) readonly buffer Spatial { float spatial[]; };  // [2 radius_y + 1][2 radius_x + 1]
layout(binding = 5, rgba32f) uniform writeonly image2D blurred_image;

vec4 blur(ivec2 pixel) {
    vec4 own = texelFetch(irradiance_image, pixel, 0);
    vec3 x = texelFetch(position_image, pixel, 0).xyz;          TAP(x, x);
    TAP(depth, own.w);
    vec3 n = texelFetch(normal_image, pixel, 0).xyz;            TAP(n, n);
    Centre centre = centre_of(x, own.w, n, u.sigma_depth, u.normal_slope);

    precise vec3 sum = own.xyz;
    precise float total = 1.0;
    int k = 0;
    for (int dy = -u.radius_y; dy <= u.radius_y; ++dy)
        for (int dx = -u.radius_x; dx <= u.radius_x; ++dx, ++k) {
            TAP_SAMPLE(k);
            ivec2 texel = pixel + ivec2(dx, dy);
            // Beyond the border there is no surface.
            bool inside = texel.x >= 0 && texel.x < u.width && texel.y >= 0 && texel.y < u.height;
            ivec2 fetched = inside ? texel : ivec2(0);
            vec4 irradiance_i = inside ? texelFetch(irradiance_image, fetched, 0) : vec4(0.0);
            TAP(irradiance_i, irradiance_i.xyz);
            vec3 x_i = inside ? texelFetch(position_image, fetched, 0).xyz : vec3(0.0);
            vec3 n_i = inside ? texelFetch(normal_image, fetched, 0).xyz : vec3(0.0);
            float of_depth = depth_weight(u.similarity == 0, centre, x_i, irradiance_i.w);
            float of_normal = normal_weight(centre, n_i, u.normal_offset);
            precise float weight = spatial[k] * of_depth * of_normal;   TAP(weight, weight);
            sum.x += weight * irradiance_i.x;
            sum.y += weight * irradiance_i.y;
            sum.z += weight * irradiance_i.z;
            total += weight;                                    TAP(total, total);
        }
    TAP_SAMPLE(-1);
    precise float n2 = n.x * n.x + n.y * n.y + n.z * n.z;
    precise vec3 mean = vec3(sum.x / total, sum.y / total, sum.z / total);
    vec3 irradiance = n2 > 0.0 ? mean : vec3(0.0);              TAP(irradiance, irradiance);
    return vec4(irradiance, own.w);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    TAP_BEGIN(pixel, 0);
    imageStore(blurred_image, pixel, blur(pixel));
}
