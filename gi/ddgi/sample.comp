#version 450
// Twin of sample_kernel.h: irradiance at a point from the eight probes of its cell.
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"
#include "gi/ddgi/octahedral.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform SampleUniforms {
    int width;         // of the points
    int height;
    int side;          // of tiles, without their gutters
    int depth_side;
    int count_x;       // probes
    int count_y;
    int count_z;
    int visibility;    // 1: by moments
    int wrapped;       // 1: by the side of the surface that a probe lies on
    int root;          // 1: means are of square roots
    int viewer;        // 1: at `eye`, 0: the image `view` tells
    float scale;       // of what texels hold, to W/m2
    float normal_bias;
    float view_bias;
    float crush;
    float least_weight;
    vec4 origin;
    vec4 spacing;
    vec4 eye;
} u;
layout(binding = 1) uniform sampler2D position_image;  // xyz world, m
layout(binding = 2) uniform sampler2D normal_image;    // xyz unit; 0: no point
layout(binding = 3) uniform sampler2D view_image;      // xyz unit, towards the viewer
layout(binding = 4) uniform sampler2D irradiance;
layout(binding = 5) uniform sampler2D moments_image;   // m, m2
layout(binding = 6, rgba32f) uniform writeonly image2D sampled_image;

// The four texels that a direction lies between, in any tile.
struct Footprint {
    ivec2 first;
    vec2 fraction;  // weight of the right and of the lower ones
};
Footprint footprint(vec3 direction, int side) {
    vec2 e = octahedral_of(direction);
    precise vec2 place = vec2(place_in_tile(e.x, side), place_in_tile(e.y, side));
    CHOICE(int(floor(place.x)));
    CHOICE(int(floor(place.y)));
    ivec2 first = max(ivec2(0), min(ivec2(floor(place)), ivec2(side)));
    precise vec2 fraction = vec2(place.x - float(first.x), place.y - float(first.y));
    return Footprint(first, fraction);
}

vec3 between(vec3 a, vec3 b, float share) {
    precise vec3 value = a + share * (b - a);
    return value;
}
vec3 look_up(sampler2D atlas, int side, ivec2 tile, Footprint at) {
    ivec2 i = tile * (side + 2) + at.first;
    vec3 a = texelFetch(atlas, i, 0).xyz;
    vec3 b = texelFetch(atlas, i + ivec2(1, 0), 0).xyz;
    vec3 c = texelFetch(atlas, i + ivec2(0, 1), 0).xyz;
    vec3 d = texelFetch(atlas, i + ivec2(1, 1), 0).xyz;
    return between(between(a, b, at.fraction.x), between(c, d, at.fraction.x), at.fraction.y);
}

// Along one axis: the first probe of the cell that x lies in, and how far behind it x is, in cells.
struct Cell {
    int first;
    float share;
};
Cell cell_of(float x, float origin, float spacing, int count) {
    precise float cells = min(max((x - origin) / spacing, 0.0), float(count - 1));
    CHOICE(int(floor(cells)));
    int first = max(0, min(int(floor(cells)), count - 1));
    precise float share = cells - float(first);
    return Cell(first, share);
}

// Chebyshev's bound of how much of what a texel saw lies at r or beyond, cubed.
float visible_share(vec3 moments, float r) {
    precise float variance = abs(moments.x * moments.x - moments.y);
    TAP(variance, variance);
    precise float behind = max(r - moments.x, 0.0);
    precise float bound = variance / max(variance + behind * behind, 1e-30);
    TAP(chebyshev, bound);
    precise float cubed = bound * bound * bound;
    return r <= moments.x ? 1.0 : cubed;
}

vec4 sample_probes(ivec2 pixel) {
    vec3 x = texelFetch(position_image, pixel, 0).xyz;            TAP(x, x);
    vec3 n = texelFetch(normal_image, pixel, 0).xyz;              TAP(n, n);
    precise vec3 v = vec3(0.0);
    if (u.viewer != 0) {
        precise vec3 d = u.eye.xyz - x;
        precise float len = max(sqrt(d.x * d.x + d.y * d.y + d.z * d.z), 1e-18);
        v = vec3(d.x / len, d.y / len, d.z / len);
    } else {
        v = texelFetch(view_image, pixel, 0).xyz;
    }
    TAP(v, v);
    precise vec3 bias = n * u.normal_bias + v * u.view_bias;      TAP(bias, bias);
    Cell cx = cell_of(x.x, u.origin.x, u.spacing.x, u.count_x);
    Cell cy = cell_of(x.y, u.origin.y, u.spacing.y, u.count_y);
    Cell cz = cell_of(x.z, u.origin.z, u.spacing.z, u.count_z);
    TAP(cell, ivec2(cx.first, cy.first));
    TAP(cell_z, cz.first);
    Footprint towards_n = footprint(n, u.side);                   TAP(texel, towards_n.first);

    precise float total = 0.0;
    precise vec3 sum = vec3(0.0);
    for (int k = 0; k < 8; ++k) {
        TAP_SAMPLE(k);
        bool right = (k & 1) != 0;
        bool up = (k & 2) != 0;
        bool far = (k & 4) != 0;
        int gx = min(cx.first + (right ? 1 : 0), u.count_x - 1);
        int gy = min(cy.first + (up ? 1 : 0), u.count_y - 1);
        int gz = min(cz.first + (far ? 1 : 0), u.count_z - 1);
        ivec2 tile = ivec2(gx + gy * u.count_x, gz);              TAP(tile, tile);
        precise vec3 p = u.origin.xyz + vec3(float(gx), float(gy), float(gz)) * u.spacing.xyz;
        TAP(p, p);
        precise vec3 d = x - p;
        precise float weight = 1.0;
        if (u.wrapped != 0) {
            precise float len = max(sqrt(d.x * d.x + d.y * d.y + d.z * d.z), 1e-18);
            precise float cosine = -((d.x * n.x + d.y * n.y + d.z * n.z) / len);
            TAP(cosine, cosine);
            precise float middle = max(0.0001, (cosine + 1.0) * 0.5);
            weight = middle * middle + 0.2;                       TAP(wrapped, weight);
        }
        if (u.visibility != 0) {
            precise vec3 biased = d + bias;
            precise float r = sqrt(biased.x * biased.x + biased.y * biased.y + biased.z * biased.z);
            TAP(r, r);
            Footprint at = footprint(biased, u.depth_side);
            vec3 moments = look_up(moments_image, u.depth_side, tile, at);
            TAP(moments, moments);
            float visible = visible_share(moments, r);            TAP(visible, visible);
            weight = weight * visible;
        }
        weight = max(u.least_weight, weight);
        precise float crushed = weight * (weight * weight * (1.0 / (u.crush * u.crush)));
        weight = weight < u.crush ? crushed : weight;             TAP(crushed, weight);
        precise float along_x = right ? cx.share : 1.0 - cx.share;
        precise float along_y = up ? cy.share : 1.0 - cy.share;
        precise float along_z = far ? cz.share : 1.0 - cz.share;
        weight = weight * (along_x * along_y * along_z);          TAP(weight, weight);
        precise vec3 e = look_up(irradiance, u.side, tile, towards_n);
        if (u.root != 0) e = vec3(sqrt(max(e.x, 0.0)), sqrt(max(e.y, 0.0)), sqrt(max(e.z, 0.0)));
        TAP(e, e);
        sum.x = sum.x + weight * e.x;
        sum.y = sum.y + weight * e.y;
        sum.z = sum.z + weight * e.z;
        total = total + weight;                                   TAP(total, total);
    }
    TAP_SAMPLE(-1);
    precise float n2 = n.x * n.x + n.y * n.y + n.z * n.z;
    bool weighed = total > 0.0;
    bool is = weighed && n2 > 0.0;
    float divisor = weighed ? total : 1.0;
    precise vec3 mean = vec3(sum.x / divisor, sum.y / divisor, sum.z / divisor);
    if (u.root != 0) mean = vec3(mean.x * mean.x, mean.y * mean.y, mean.z * mean.z);
    precise vec3 scaled = mean * u.scale;
    vec3 result = is ? scaled : vec3(0.0);                        TAP(irradiance, result);
    return vec4(result, is ? total : 0.0);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    TAP_BEGIN(pixel, 0);
    imageStore(sampled_image, pixel, sample_probes(pixel));
}
