#version 450
// Twin of blur_kernel.h: the blur of the coarse result along rows or columns (ISR 4.2, Listing 3).
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"
#include "raster/normal.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform BlurUniforms {
    vec4 right;     // xyz: what x of a pixel adds to its ray at eye depth 1, m; of edge_aware alone
    vec4 down;
    vec4 origin;
    int width;
    int height;
    int radius;
    int vertical;  // 0: along rows, 1: along columns
    int kind;      // 0 gaussian, 1 edge_aware, 2 published
} u;
layout(binding = 1) uniform sampler2D lit_image;      // xyz irradiance, W/m2, w accessibility
layout(binding = 2) uniform sampler2D surface_image;  // xyz unit normal, w linear eye depth, m; all 0 where none is
layout(std430, binding = 3) readonly buffer Spatial { float spatial[]; };  // [2 radius + 1]
layout(binding = 4, rgba32f) uniform writeonly image2D blurred_image;

const float edge_distance = 0.02;

struct BlurTexel {
    vec3 irradiance;
    float accessibility;
    float covered;
    vec3 normal;
    float depth;
};

// d pixels further along the row or the column.
BlurTexel at(ivec2 pixel, int d) {
    ivec2 texel = u.vertical != 0 ? ivec2(pixel.x, pixel.y + d) : ivec2(pixel.x + d, pixel.y);
    bool inside = texel.x >= 0 && texel.x < u.width && texel.y >= 0 && texel.y < u.height;
    ivec2 fetched = min(max(texel, ivec2(0)), ivec2(u.width - 1, u.height - 1));
    vec4 lit = texelFetch(lit_image, fetched, 0);
    vec4 surface = texelFetch(surface_image, fetched, 0);
    vec3 n = surface.xyz;
    bool covered = inside && dot3(n, n) > 0.0;
    vec3 normal = inside ? n : vec3(0.0);
    return BlurTexel(lit.xyz, lit.w, covered ? 1.0 : 0.0, normal, surface.w);
}

// n . r of the pixels along a row or a column: `own` of the pixel itself, `each` more for every pixel further.
struct Facing {
    float own;
    float each;
};

Facing facing_of(ivec2 pixel, vec3 n) {
    precise vec3 ray = u.right.xyz * float(pixel.x) + u.down.xyz * float(pixel.y) + u.origin.xyz;
    return Facing(dot3(n, ray), dot3(n, u.vertical != 0 ? u.down.xyz : u.right.xyz));
}

// max(0, 1 - q^2) max(0, n . n_i), i being d pixels away.
float edge_weight(BlurTexel c, Facing f, BlurTexel t, int d) {
    precise float away = f.own * (t.depth - c.depth) + (f.each * float(d)) * t.depth;
    TAP(away, away);
    precise float q = away / max(edge_distance * c.depth, 1e-37);
    precise float of_plane = max(0.0, 1.0 - q * q);             TAP(of_plane, of_plane);
    precise float of_normal = max(0.0, dot3(c.normal, t.normal));
    TAP(of_normal, of_normal);
    precise float weight = of_plane * of_normal;
    return weight;
}

vec4 blur(ivec2 pixel) {
    BlurTexel c = at(pixel, 0);                                 TAP(n, c.normal);
    TAP(depth, c.depth);
    Facing facing = facing_of(pixel, c.normal);
    precise vec3 sum = vec3(0.0);
    precise float open = 0.0;
    precise float total = 0.0;
    for (int k = 0; k <= u.radius + u.radius; ++k) {
        TAP_SAMPLE(k);
        BlurTexel t = at(pixel, k - u.radius);                  TAP(irradiance_i, t.irradiance);
        TAP(accessibility_i, t.accessibility);
        precise float weight = spatial[k];
        if (u.kind == 0) weight = weight * t.covered;
        if (u.kind == 1) weight = weight * t.covered * edge_weight(c, facing, t, k - u.radius);
        TAP(weight, weight);
        sum.x += weight * t.irradiance.x;
        sum.y += weight * t.irradiance.y;
        sum.z += weight * t.irradiance.z;
        open += weight * t.accessibility;
        total += weight;                                        TAP(total, total);
    }
    TAP_SAMPLE(-1);
    precise vec3 irradiance = sum;
    precise float accessibility = open;
    if (u.kind != 2) {
        float divisor = total > 0.0 ? total : 1.0;
        bool covered = c.covered > 0.0;
        precise vec3 mean = vec3(sum.x / divisor, sum.y / divisor, sum.z / divisor);
        precise float mean_open = open / divisor;
        irradiance = covered ? mean : vec3(0.0);
        accessibility = covered ? mean_open : 1.0;
    }
    TAP(irradiance, irradiance);
    TAP(accessibility, accessibility);
    return vec4(irradiance, accessibility);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    TAP_BEGIN(pixel, 0);
    imageStore(blurred_image, pixel, blur(pixel));
}
