#version 450
// Twin of mirror_kernel.h: what mirrors show.
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform MirrorUniforms {
    float inv_pi;
    float fade;
    float attenuation;
    int width;
    int height;
    float share;
    int rays;
    int across;
    int others;
} u;
layout(binding = 1) uniform sampler2D hit_image;       // xy texel, z distance, w view
layout(binding = 2) uniform sampler2D mirror_image;    // xyz reflectance
layout(binding = 3) uniform sampler2D composed_image;  // the picture without reflections, W/(m2 sr)
layout(binding = 4) uniform sampler2D albedo_image;    // of what was met in another view
layout(binding = 5) uniform sampler2D emission_image;  // W/m2
layout(binding = 6) uniform sampler2D direct_image;    // W/m2
layout(binding = 7) uniform sampler2D lobe_image;      // xyz reflectance of Phong's lobe
layout(binding = 8) uniform sampler2D drawn_image;     // w weight of a lobe's ray
layout(binding = 9, rgba32f) uniform writeonly image2D reflection_image;
layout(binding = 10, rgba32f) uniform writeonly image2D radiance_image;

float fade_of(vec4 hit) {
    precise float x = hit.x + 0.5;
    precise float y = hit.y + 0.5;
    precise float right = float(u.width) - x;
    precise float below = float(u.height) - y;
    float nearest = min(min(x, right), min(y, below));
    precise float fade = min(max(nearest / u.fade, 0.0), 1.0);    TAP(fade, fade);
    return fade;
}

// What one ray of a pixel shows, w 1 where it met something. item: of the sheet; k: what its light is multiplied by.
vec4 shown_by(ivec2 item, ivec2 pixel, vec3 k) {
    vec4 hit = texelFetch(hit_image, item, 0);                    TAP(distance, hit.z);
    bool met = hit.w > 0.0;
    ivec2 at = ivec2(hit.xy);
    bool of_camera = hit.w == 1.0 && at.x >= 0 && at.x < u.width && at.y >= 0 && at.y < u.height;
    vec3 shown = texelFetch(composed_image, of_camera ? at : pixel, 0).xyz;
    TAP(shown, shown);
    vec3 rho = u.others != 0 ? texelFetch(albedo_image, item, 0).xyz : vec3(0.0);
    vec3 m = u.others != 0 ? texelFetch(emission_image, item, 0).xyz : vec3(0.0);
    vec3 e = u.others != 0 ? texelFetch(direct_image, item, 0).xyz : vec3(0.0);
    precise vec3 lit = (rho * e + m) * u.inv_pi;                  TAP(lit, lit);
    precise float factor = 1.0;
    if (u.fade > 0.0) {
        float fade = fade_of(hit);
        factor = of_camera ? fade : 1.0;
    }
    precise float far = hit.z * u.attenuation;
    factor = factor * (1.0 / (1.0 + far * far));                  TAP(factor, factor);
    TAP(mirror, k);
    vec3 from = of_camera ? shown : lit;
    precise vec3 mirrored = k * (factor * from);
    return met ? vec4(mirrored, 1.0) : vec4(0.0);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    TAP_BEGIN(pixel, 0);
    vec3 k = texelFetch(mirror_image, pixel, 0).xyz;
    vec3 k_s = texelFetch(lobe_image, pixel, 0).xyz;
    precise vec3 l_r = vec3(0.0);
    float met = 0.0;
    for (int j = 0; j <= u.rays; ++j) {
        TAP_SAMPLE(j);
        ivec2 item = pixel + ivec2(j % u.across, j / u.across) * ivec2(u.width, u.height);
        if (j > 0) {
            float w = texelFetch(drawn_image, item, 0).w;
            precise float share = w * u.share;                    TAP(weight, w);
            precise vec3 k_of = k_s * share;
            k = k_of;
        }
        vec4 by = shown_by(item, pixel, k);
        l_r = l_r + by.xyz;
        met = max(met, by.w);
    }
    TAP_SAMPLE(-1);
    TAP(reflection, l_r);
    vec4 l_0 = texelFetch(composed_image, pixel, 0);
    precise vec3 l = l_0.xyz + l_r;                               TAP(radiance, l);
    imageStore(reflection_image, pixel, vec4(l_r, met));
    imageStore(radiance_image, pixel, vec4(l, l_0.w));
}
