#version 450
// Twin of lobe_kernel.h: rays of rough reflections.
#extension GL_GOOGLE_include_directive : require
#include "core/detmath.glsl"
#include "core/hash.glsl"
#include "core/tap.glsl"
#include "gi/screen/mirrored_ray.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform LobeUniforms {
    vec4 eye;
    int columns;
    int rows;
    int across;
    int rays;
    int seed;
    int width;
    int height;
} u;
layout(binding = 1) uniform sampler2D position_image;  // xyz world, m
layout(binding = 2) uniform sampler2D normal_image;    // xyz unit; all 0: no surface
layout(binding = 3) uniform sampler2D mirror_image;    // w 0: no mirror
layout(binding = 4) uniform sampler2D lobe_image;      // xyz reflectance, w exponent; xyz 0: none
layout(binding = 5, rgba32f) uniform writeonly image2D ray_image;

// The cosine and sine of t pi/4, |t| <= 1, and of 2 pi turn: gi/reference/warp_kernel.h.
vec2 eighth_turn(float t) {
    precise float x = t * t;
    precise float cosine = 1.0 - x * (0.308425128 + x * (-0.0158542674 + x * (0.000325820176 + x * -3.46135539e-06)));
    precise float sine = t * (0.785398185 + x * (-0.0807456225 + x * (0.00249037519 + x * -3.61621242e-05)));
    return vec2(cosine, sine);
}
vec2 on_circle(float turn) {
    precise float quarters = turn * 4.0;
    int quarter = int(roundEven(quarters));
    precise float rest = (quarters - float(quarter)) * 2.0;
    vec2 p = eighth_turn(rest);
    bool swapped = (quarter & 1) == 1;
    float cosine = swapped ? p.y : p.x;
    float sine = swapped ? p.x : p.y;
    return vec2(((quarter + 1) & 2) == 2 ? -cosine : cosine, (quarter & 2) == 2 ? -sine : sine);
}

// A direction about z: cos = (1 - u_1)^(1 / (n + 1)).
vec3 about_z(float u_1, float u_2, float exponent) {
    precise float rest = 1.0 - u_1;
    precise float lower = exponent + 1.0;
    precise float power = det_log(rest) / lower;
    precise float versine = -det_expm1(power);                    TAP(versine, versine);
    precise float squared = versine * (2.0 - versine);
    float sine = sqrt(max(squared, 0.0));
    vec2 around = on_circle(u_2);
    precise vec3 local = vec3(sine * around.x, sine * around.y, 1.0 - versine);
    return local;
}

vec4 lobe(ivec2 item) {
    ivec2 of_sheet = ivec2(item.x / u.columns, item.y / u.rows);
    ivec2 pixel = item - of_sheet * ivec2(u.columns, u.rows);
    int block = of_sheet.y * u.across + of_sheet.x;
    vec3 p = texelFetch(position_image, pixel, 0).xyz;            TAP(p, p);
    vec3 n = texelFetch(normal_image, pixel, 0).xyz;              TAP(n, n);
    precise vec3 to_p = p - u.eye.xyz;
    MirroredRay about = mirrored_ray(p, n, to_p, u.eye.xyz);
    vec4 of = texelFetch(lobe_image, pixel, 0);                   TAP(exponent, of.w);
    uvec3 hash = pixel_hash(uint(pixel.x), uint(pixel.y), uint(block), uint(u.seed));
    vec3 local = about_z(unit_float(hash.x), unit_float(hash.y), of.w);
    // Duff et al. 2017, "Building an Orthonormal Basis, Revisited".
    vec3 r = about.r;
    float side = r.z < 0.0 ? -1.0 : 1.0;
    precise float a = -1.0 / (side + r.z);
    precise float b = r.x * r.y * a;
    precise vec3 tangent = vec3(1.0 + side * r.x * r.x * a, side * b, -(side * r.x));
    precise vec3 bitangent = vec3(b, side + r.y * r.y * a, -r.y);
    precise vec3 drawn = tangent * local.x + bitangent * local.y + r * local.z;
    precise float cosine = n.x * drawn.x + n.y * drawn.y + n.z * drawn.z;
    TAP(rises, cosine);
    precise float weight = (of.w + 2.0) / (of.w + 1.0) * max(cosine, 0.0);
    TAP(weight, weight);
    bool mirror = texelFetch(mirror_image, pixel, 0).w > 0.0;
    bool rough = of.x > 0.0 || of.y > 0.0 || of.z > 0.0;
    bool first = block == 0;
    bool leaves = about.cosine < 0.0 && (first ? mirror : rough && cosine > 0.0 && block <= u.rays);
    vec3 ray = leaves ? (first ? r : drawn) : vec3(0.0);
    float of_ray = leaves ? (first ? 1.0 : weight) : 0.0;
    TAP(ray, ray);
    TAP(share, of_ray);
    return vec4(ray, of_ray);
}

void main() {
    ivec2 item = ivec2(gl_GlobalInvocationID.xy);
    if (item.x >= u.width || item.y >= u.height) return;
    TAP_BEGIN(item, 0);
    imageStore(ray_image, item, lobe(item));
}
