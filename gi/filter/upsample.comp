#version 450
// Twin of upsample_kernel.h: half-size irradiance to full size (VRSM 4.5).
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"
#include "gi/filter/weights.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform UpsampleUniforms {
    int width;
    int height;
    int coarse_width;
    int coarse_height;
    int mode;        // 0 bilateral, 1 bilinear, 2 published
    int similarity;  // 0 plane, 1 depth
    float sigma_depth;
    float normal_slope;
    float normal_offset;
} u;
layout(binding = 1) uniform sampler2D coarse_irradiance;  // xyz W/m2, w linear depth, m
layout(binding = 2) uniform sampler2D coarse_position;    // xyz world, m
layout(binding = 3) uniform sampler2D coarse_normal;      // xyz unit
layout(binding = 4) uniform sampler2D position_image;     // xyz world, m, w linear depth, m
layout(binding = 5) uniform sampler2D normal_image;       // xyz unit
layout(binding = 6, rgba32f) uniform writeonly image2D upsampled_image;

// The two coarse pixels that x lies between along an axis, and the second one's share.
struct Between {
    int first;
    int second;
    float share;
};
Between between(int x, int size, int coarse_size, bool published) {
    if (published) {
        int first = (x - 1) >> 1;
        float share = (x & 1) == 0 ? 0.75 : 0.25;
        return Between(max(first, 0), min(first + 1, coarse_size - 1), share);
    }
    int first = max((x - 1) >> 1, 0);
    int second = min(x >> 1, coarse_size - 1);
    int picked = min(second + second + 1, size - 1);
    float share = first == second ? 0.0 : (picked == x ? 1.0 : 0.5);
    return Between(first, second, share);
}

vec4 upsample(ivec2 pixel) {
    vec4 x = texelFetch(position_image, pixel, 0);              TAP(x, x.xyz);
    TAP(depth, x.w);
    vec3 n = texelFetch(normal_image, pixel, 0).xyz;            TAP(n, n);
    bool published = u.mode == 2;
    Between across = between(pixel.x, u.width, u.coarse_width, published);
    Between down = between(pixel.y, u.height, u.coarse_height, published);
    Centre centre = centre_of(x.xyz, x.w, n, u.sigma_depth, u.normal_slope);

    precise float total = 0.0;
    float least = 3.4e38;
    precise vec3 sum = vec3(0.0);
    vec3 nearest = vec3(0.0);
    for (int k = 0; k < 4; ++k) {
        TAP_SAMPLE(k);
        bool right = (k & 1) != 0;
        bool below = (k & 2) != 0;
        ivec2 coarse = ivec2(right ? across.second : across.first, below ? down.second : down.first);
        TAP(coarse, coarse);
        vec4 irradiance = texelFetch(coarse_irradiance, coarse, 0);
        vec3 n_i = texelFetch(coarse_normal, coarse, 0).xyz;
        vec3 x_i = texelFetch(coarse_position, coarse, 0).xyz;
        precise float share_x = right ? across.share : 1.0 - across.share;
        precise float share_y = below ? down.share : 1.0 - down.share;
        precise float bilinear = share_x * share_y;             TAP(bilinear, bilinear);
        precise float weight = bilinear;
        if (u.mode == 0) {
            float of_depth = depth_weight(u.similarity == 0, centre, x_i, irradiance.w);
            float of_normal = normal_weight(centre, n_i, u.normal_offset);
            weight = bilinear * of_depth * of_normal;
        }
        TAP(weight, weight);
        sum.x += weight * irradiance.x;
        sum.y += weight * irradiance.y;
        sum.z += weight * irradiance.z;
        total += weight;                                        TAP(total, total);

        // Where no weight is left: the surface that is nearest in depth, of those that have a share.
        precise float off = abs(irradiance.w - x.w);
        precise float length2 = n_i.x * n_i.x + n_i.y * n_i.y + n_i.z * n_i.z;
        bool nearer = bilinear > 0.0 && length2 > 0.0 && off < least;
        least = nearer ? off : least;
        nearest = nearer ? irradiance.xyz : nearest;
    }
    TAP_SAMPLE(-1);
    bool weighed = total > 0.0;                                 TAP(weighed, weighed);
    float divisor = weighed ? total : 1.0;
    precise vec3 mean = vec3(sum.x / divisor, sum.y / divisor, sum.z / divisor);
    precise float n2 = n.x * n.x + n.y * n.y + n.z * n.z;
    vec3 irradiance = weighed ? mean : nearest;
    irradiance = n2 > 0.0 ? irradiance : vec3(0.0);             TAP(irradiance, irradiance);
    return vec4(irradiance, x.w);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    TAP_BEGIN(pixel, 0);
    imageStore(upsampled_image, pixel, upsample(pixel));
}
