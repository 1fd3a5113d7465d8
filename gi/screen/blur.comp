#version 450
// Twin of blur_kernel.h: the mean over views, and a box of 4 x 4 pixels over it (LRA 6.2.3).
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"
#include "gi/filter/weights.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform BlurUniforms {
    int width;
    int height;
    int first;
    int last;
    int published;
    int edges;
    float sigma_depth;
    float normal_slope;
    float normal_offset;
} u;
layout(binding = 1) uniform sampler2D summed_image;    // sum w o; sum w; o of the receivers' own view; 1 on a surface
layout(binding = 2) uniform sampler2D position_image;  // xyz world, m; w linear depth, m
layout(binding = 3) uniform sampler2D normal_image;    // xyz unit
layout(binding = 4, rgba32f) uniform writeonly image2D open_image;

float mean_of(vec4 summed) {
    bool weighed = summed.y > 0.0;
    precise float mean = summed.x / (weighed ? summed.y : 1.0);
    return weighed ? mean : summed.z;
}

// 1 2 2 2 1, over 8.
float box_weight(int at) { return at == -2 || at == 2 ? 0.125 : 0.25; }

vec4 blur(ivec2 pixel) {
    vec4 summed = texelFetch(summed_image, pixel, 0);
    float own = mean_of(summed);                                  TAP(own, own);
    bool covered = summed.w > 0.0;
    vec4 x = texelFetch(position_image, pixel, 0);
    vec3 n = texelFetch(normal_image, pixel, 0).xyz;
    Centre centre = centre_of(x.xyz, x.w, n, u.sigma_depth, u.normal_slope);
    precise float sum = 0.0;
    precise float total = 0.0;
    int side = u.last - u.first + 1;
    for (int k = 0; covered && k < side * side; ++k) {
        TAP_SAMPLE(k);
        ivec2 offset = ivec2(u.first + k % side, u.first + k / side);
        ivec2 at = clamp(pixel + offset, ivec2(0), ivec2(u.width - 1, u.height - 1));
        bool inside = at == pixel + offset;
        vec4 other = texelFetch(summed_image, at, 0);
        precise float weight = u.published != 0 ? 1.0 : box_weight(offset.x) * box_weight(offset.y);
        if (u.edges != 0) {
            vec4 x_i = texelFetch(position_image, at, 0);
            vec3 n_i = texelFetch(normal_image, at, 0).xyz;
            float of_depth = depth_weight(true, centre, x_i.xyz, x_i.w);
            float of_normal = normal_weight(centre, n_i, u.normal_offset);
            weight = weight * of_depth * of_normal;
        }
        weight = u.published != 0 || (inside && other.w > 0.0) ? weight : 0.0;
        TAP(weight, weight);
        sum += weight * mean_of(other);
        total += weight;
    }
    TAP_SAMPLE(-1);
    bool weighed = total > 0.0;
    precise float mean = sum / (weighed ? total : 1.0);
    float open = covered ? (weighed ? mean : own) : 0.0;          TAP(open, open);
    return vec4(open, open, open, covered ? 1.0 : 0.0);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    TAP_BEGIN(pixel, 0);
    imageStore(open_image, pixel, blur(pixel));
}
