#version 450
// Twin of relief_kernel.h: normal maps and highlights by the light vector.
#extension GL_GOOGLE_include_directive : require
#include "core/detmath.glsl"
#include "core/tap.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform ReliefUniforms {
    int width;
    int height;
    int maps;        // 1: normal maps
    int highlights;  // 1: highlights
    float most;      // of the ratio
    vec4 eye;
} u;
layout(binding = 1) uniform sampler2D position_image;    // xyz world, m
layout(binding = 2) uniform sampler2D normal_image;      // xyz unit, mapped; w 1: a point
layout(binding = 3) uniform sampler2D irradiance_image;  // W/m2
layout(binding = 4) uniform sampler2D mapped_image;      // of the volume, along the mapped normal
layout(binding = 5) uniform sampler2D plain_image;       // of the volume, along the plain normal
layout(binding = 6) uniform sampler2D light_image;       // xyz unit
layout(binding = 7) uniform sampler2D from_light_image;  // W/m2
layout(binding = 8) uniform sampler2D specular_image;    // k_s, w the exponent
layout(binding = 9, rgba32f) uniform writeonly image2D relieved_image;
layout(binding = 10, rgba32f) uniform writeonly image2D glossy_image;

void relief(ivec2 pixel) {
    vec4 normal = texelFetch(normal_image, pixel, 0);
    vec3 n = normal.xyz;                                          TAP(n, n);
    bool point = normal.w > 0.0;
    vec3 e = texelFetch(irradiance_image, pixel, 0).xyz;          TAP(E, e);
    vec4 mapped = texelFetch(mapped_image, pixel, 0);
    vec4 plain = texelFetch(plain_image, pixel, 0);
    precise float above = mapped.x + mapped.y + mapped.z;
    precise float below = plain.x + plain.y + plain.z;
    TAP(above, above);
    TAP(below, below);
    bool known = plain.w > 0.0 && below > 1e-30;
    precise float ratio = min(above / (known ? below : 1.0), u.most);
    float r = u.maps != 0 ? (known ? ratio : 1.0) : 1.0;          TAP(r, r);

    vec3 x = texelFetch(position_image, pixel, 0).xyz;            TAP(x, x);
    precise vec3 d = u.eye.xyz - x;
    precise float len = max(sqrt(d.x * d.x + d.y * d.y + d.z * d.z), 1e-18);
    precise vec3 v = vec3(d.x / len, d.y / len, d.z / len);       TAP(v, v);
    vec3 l = texelFetch(light_image, pixel, 0).xyz;               TAP(l, l);
    precise float n_l = n.x * l.x + n.y * l.y + n.z * l.z;
    precise float n_v = n.x * v.x + n.y * v.y + n.z * v.z;
    precise float v_l = v.x * l.x + v.y * l.y + v.z * l.z;
    float facing = n_l > 0.0 ? n_l : 0.0;                         TAP(facing, facing);
    precise float mirrored = 2.0 * n_v * n_l - v_l;
    float cosine = min(max(mirrored, 0.0), 1.0);                  TAP(mirrored, cosine);
    vec4 k = texelFetch(specular_image, pixel, 0);                TAP(k, k.xyz);
    TAP(exponent, k.w);
    float exponent = max(k.w, 0.0);
    float raised = det_pow(cosine, exponent);
    float power = cosine > 0.0 && raised > 1e-30 ? raised : 0.0;  TAP(power, power);
    precise float lobe = (exponent + 2.0) * 0.159154943 * power * facing;
    TAP(lobe, lobe);
    vec3 arriving = texelFetch(from_light_image, pixel, 0).xyz;   TAP(E_l, arriving);
    precise float shown = (point && u.highlights != 0 ? 1.0 : 0.0) * lobe;
    precise float scale = (point ? 1.0 : 0.0) * r;
    precise vec3 relieved = e * scale;
    precise vec3 glossy = vec3(k.x * arriving.x * shown, k.y * arriving.y * shown, k.z * arriving.z * shown);
    imageStore(relieved_image, pixel, vec4(relieved, point ? 1.0 : 0.0));
    imageStore(glossy_image, pixel, vec4(glossy, point ? 1.0 : 0.0));
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    TAP_BEGIN(pixel, 0);
    relief(pixel);
}
