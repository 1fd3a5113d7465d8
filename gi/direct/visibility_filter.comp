#version 450
// Twin of visibility_filter_kernel.h: a filter of a light's shadows over the screen, along rows or columns (ISR 4.7).
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"
#include "gi/filter/weights.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform VisibilityFilterUniforms {
    int width;
    int height;
    int radius;
    int vertical;  // 0: along rows, 1: along columns
    int kind;      // 0 gaussian, 1 edge_aware
    float sigma_depth;
    float normal_slope;
    float normal_offset;
} u;
layout(binding = 1) uniform sampler2D visibility_image;  // 1 lit, 0 shadowed
layout(binding = 2) uniform sampler2D position_image;    // xyz world, m, w linear depth, m; of kind = 1
layout(binding = 3) uniform sampler2D normal_image;      // xyz unit; all 0 where no surface is
layout(std430, binding = 4) readonly buffer Spatial { float spatial[]; };  // [2 radius + 1]; 0 in the middle
layout(binding = 5, r32f) uniform writeonly image2D filtered_image;

float visibility_filter(ivec2 pixel) {
    float own = texelFetch(visibility_image, pixel, 0).x;       TAP(own, own);
    vec3 n = texelFetch(normal_image, pixel, 0).xyz;            TAP(n, n);
    Centre centre = Centre(vec3(0.0), 0.0, 0.0, vec3(0.0), vec3(0.0));
    if (u.kind == 1) {
        vec4 x = texelFetch(position_image, pixel, 0);          TAP(x, x.xyz);
        TAP(depth, x.w);
        centre = centre_of(x.xyz, x.w, n, u.sigma_depth, u.normal_slope);
    }

    precise float sum = own;
    precise float total = 1.0;
    for (int k = 0; k <= u.radius + u.radius; ++k) {
        TAP_SAMPLE(k);
        int along = k - u.radius;
        ivec2 texel = u.vertical != 0 ? ivec2(pixel.x, pixel.y + along) : ivec2(pixel.x + along, pixel.y);
        bool inside = texel.x >= 0 && texel.x < u.width && texel.y >= 0 && texel.y < u.height;
        ivec2 fetched = inside ? texel : pixel;
        vec3 n_i = texelFetch(normal_image, fetched, 0).xyz;
        precise float n2_i = n_i.x * n_i.x + n_i.y * n_i.y + n_i.z * n_i.z;
        bool covered = inside && n2_i > 0.0;
        // What has no surface, or lies beyond the border, counts by 0.
        float visibility_i = covered ? texelFetch(visibility_image, fetched, 0).x : own;
        TAP(visibility_i, visibility_i);
        precise float weight = covered ? spatial[k] : 0.0;
        if (u.kind == 1) {
            vec4 x_i = texelFetch(position_image, fetched, 0);
            float of_depth = depth_weight(true, centre, x_i.xyz, x_i.w);
            float of_normal = normal_weight(centre, n_i, u.normal_offset);
            weight = weight * of_depth * of_normal;
        }
        TAP(weight, weight);
        sum += weight * visibility_i;
        total += weight;                                        TAP(total, total);
    }
    TAP_SAMPLE(-1);
    precise float mean = sum / total;
    precise float n2 = n.x * n.x + n.y * n.y + n.z * n.z;
    float filtered = n2 > 0.0 ? mean : own;                     TAP(filtered, filtered);
    return filtered;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    TAP_BEGIN(pixel, 0);
    imageStore(filtered_image, pixel, vec4(visibility_filter(pixel), 0.0, 0.0, 0.0));
}
