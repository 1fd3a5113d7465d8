#version 450
// Twin of relief_kernel.h: normal maps and highlights by the light vector.
#extension GL_GOOGLE_include_directive : require
#include "core/detmath.glsl"
#include "core/tap.glsl"
#include "raster/light.glsl"
#include "raster/arriving.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform ReliefUniforms {
    int width;
    int height;
    int maps;        // 1: normal maps
    int highlights;  // 1: highlights
    float most;      // of the ratio
    int lights;
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
layout(std430, binding = 9) readonly buffer Lights { LightArgs lights[]; };
layout(binding = 10) uniform sampler2DArray visibility_image;  // a layer a light: 1 lit, 0 shadowed
layout(binding = 11, rgba32f) uniform writeonly image2D relieved_image;
layout(binding = 12, rgba32f) uniform writeonly image2D glossy_image;

// rho(w): what of irradiance that arrives along w the lobe sends to the viewer, 1/sr.
float lobe_towards(vec3 n, vec3 v, float n_v, float exponent, vec3 w) {
    precise float n_w = n.x * w.x + n.y * w.y + n.z * w.z;
    precise float v_w = v.x * w.x + v.y * w.y + v.z * w.z;
    float facing = n_w > 0.0 ? n_w : 0.0;                         TAP(facing, facing);
    precise float mirrored = 2.0 * n_v * n_w - v_w;
    float cosine = min(max(mirrored, 0.0), 1.0);                  TAP(mirrored, cosine);
    float raised = det_pow(cosine, exponent);
    float power = cosine > 0.0 && raised > 1e-30 ? raised : 0.0;  TAP(power, power);
    precise float lobe = (exponent + 2.0) * 0.159154943 * power * facing;
    TAP(lobe, lobe);
    return lobe;
}

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
    precise float n_v = n.x * v.x + n.y * v.y + n.z * v.z;
    vec4 k = texelFetch(specular_image, pixel, 0);                TAP(k, k.xyz);
    TAP(exponent, k.w);
    float exponent = max(k.w, 0.0);
    vec3 arriving = texelFetch(from_light_image, pixel, 0).xyz;   TAP(E_l, arriving);
    precise vec3 sum = arriving * lobe_towards(n, v, n_v, exponent, l);
    for (int i = 0; i < u.lights; ++i) {
        TAP_SAMPLE(i);
        vec3 w;
        vec3 lamp = arriving_from(lights[i], x, w);               TAP(w, w);
        float visibility = texelFetch(visibility_image, ivec3(pixel, i), 0).x;
        TAP(visibility, visibility);
        precise float lobe = visibility * lobe_towards(n, v, n_v, exponent, w);
        precise vec3 one = lamp * lobe;                           TAP(E_lobe, one);
        sum += one;
    }
    TAP_SAMPLE(-1);
    precise float channels = k.x + k.y + k.z;
    bool shown = point && channels > 0.0 && u.highlights != 0;
    precise float scale = (point ? 1.0 : 0.0) * r;
    precise vec3 relieved = e * scale;                            TAP(relieved, relieved);
    precise vec3 lit = k.xyz * sum;
    vec3 glossy = shown ? lit : vec3(0.0);                        TAP(glossy, glossy);
    imageStore(relieved_image, pixel, vec4(relieved, point ? 1.0 : 0.0));
    imageStore(glossy_image, pixel, vec4(glossy, point ? 1.0 : 0.0));
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    TAP_BEGIN(pixel, 0);
    relief(pixel);
}
