#version 450
// Twin of upsample_kernel.h: the coarse result to every pixel (ISR 4.5).
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform UpsampleUniforms {
    int width;
    int height;
    int coarse_width;
    int coarse_height;
    int bilateral;   // 0: bilinear shares alone
    int published;
    int clip_depth;  // 1: surface.w of the coarse image is a depth of clip space
    float epsilon;
    float far;                // m
    float per_near;           // 1 / near, 1/m
    float per_far_less_near;  // 1 / far - 1 / near, 1/m
} u;
layout(binding = 1) uniform sampler2D lit_image;       // coarse: xyz irradiance, W/m2, w accessibility
layout(binding = 2) uniform sampler2D surface_image;   // coarse: xyz unit normal, w depth; all 0 where none is
layout(binding = 3) uniform sampler2D position_image;  // w linear eye depth, m
layout(binding = 4) uniform sampler2D normal_image;    // xyz unit; all 0 where nothing is
layout(binding = 5, rgba32f) uniform writeonly image2D upsampled_image;

struct UpsampleTexel {
    vec3 irradiance;
    float accessibility;
    float covered;
    float depth;
};

float coarse_depth(float depth) {
    if (u.clip_depth == 0) return depth;
    precise float z = 1.0 / max(u.per_near + depth * u.per_far_less_near, 1e-30);
    return z;
}

UpsampleTexel coarse_texel(ivec2 i) {
    vec4 lit = texelFetch(lit_image, i, 0);
    vec4 surface = texelFetch(surface_image, i, 0);
    vec3 n = surface.xyz;
    precise float n2 = n.x * n.x + n.y * n.y + n.z * n.z;
    bool covered = n2 > 0.0;
    float depth = coarse_depth(surface.w);
    return UpsampleTexel(lit.xyz, lit.w, covered ? 1.0 : 0.0, covered ? depth : 0.0);
}

// The coarse pixel before and the one after x along an axis.
int coarse_before(int x) { return max((x - 1) >> 1, 0); }
int coarse_after(int x, int coarse_size) { return min((x + 1) >> 1, coarse_size - 1); }

UpsampleTexel at(ivec2 pixel, bool right, bool below) {
    int x = right ? coarse_after(pixel.x, u.coarse_width) : coarse_before(pixel.x);
    int y = below ? coarse_after(pixel.y, u.coarse_height) : coarse_before(pixel.y);
    return coarse_texel(ivec2(x, y));
}

vec4 upsample(ivec2 pixel) {
    float z = texelFetch(position_image, pixel, 0).w;           TAP(depth, z);
    vec3 n = texelFetch(normal_image, pixel, 0).xyz;            TAP(n, n);
    float share_x = (pixel.x & 1) == 0 ? 0.75 : 0.25;
    float share_y = (pixel.y & 1) == 0 ? 0.75 : 0.25;
    float scale = u.published != 0 ? u.far : max(z, 1e-37);     TAP(scale, scale);

    UpsampleTexel coarse[4];
    precise float weights[4];
    precise float shares[4];
    precise float total = 0.0;
    precise float share = 0.0;
    for (int k = 0; k < 4; ++k) {
        TAP_SAMPLE(k);
        bool right = (k & 1) != 0;
        bool below = (k & 2) != 0;
        UpsampleTexel t = at(pixel, right, below);              TAP(z_i, t.depth);
        coarse[k] = t;
        precise float of_x = right ? share_x : 1.0 - share_x;
        precise float of_y = below ? share_y : 1.0 - share_y;
        precise float bilinear = of_x * of_y;                   TAP(bilinear, bilinear);
        shares[k] = u.published != 0 ? bilinear : bilinear * t.covered;
        weights[k] = shares[k];
        if (u.bilateral != 0) {
            precise float of_depth = 1.0 / (u.epsilon + abs(z - t.depth) / scale);
            TAP(of_depth, of_depth);
            weights[k] = shares[k] * of_depth;
        }
        TAP(weight, weights[k]);
        share += shares[k];
        total += weights[k];                                    TAP(total, total);
    }
    // Where no weight is left: bilinear, of those that have a surface.
    bool weighed = total > 0.0;
    float divisor = weighed ? total : (share > 0.0 ? share : 1.0);
    precise vec3 sum = vec3(0.0);
    precise float open = 0.0;
    for (int k = 0; k < 4; ++k) {
        TAP_SAMPLE(k);
        UpsampleTexel t = coarse[k];
        precise float w = (weighed ? weights[k] : shares[k]) / divisor;  TAP(w, w);
        sum.x += w * t.irradiance.x;
        sum.y += w * t.irradiance.y;
        sum.z += w * t.irradiance.z;
        open += w * t.accessibility;
    }
    TAP_SAMPLE(-1);
    precise float n2 = n.x * n.x + n.y * n.y + n.z * n.z;
    bool lit = n2 > 0.0 && share > 0.0;
    vec3 irradiance = lit ? sum : vec3(0.0);                    TAP(irradiance, irradiance);
    float accessibility = lit ? open : 1.0;                     TAP(accessibility, accessibility);
    return vec4(irradiance, accessibility);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    TAP_BEGIN(pixel, 0);
    imageStore(upsampled_image, pixel, upsample(pixel));
}
