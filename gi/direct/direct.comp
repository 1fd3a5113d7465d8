#version 450
// Twin of direct_kernel.h: direct irradiance from point-like and directional lights.
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"
#include "raster/light.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform DirectUniforms {
    int lights;
    int width;
    int height;
    int density;  // 1: w is the shadow density, 2: so is E / pi, 0: w is 0
} u;
layout(binding = 1) uniform sampler2D position_image;         // xyz world, m
layout(binding = 2) uniform sampler2D normal_image;           // xyz unit, w 1; all 0 where nothing is
layout(std430, binding = 3) readonly buffer Lights { LightArgs lights[]; };
layout(binding = 4) uniform sampler2DArray visibility_image;  // a layer a light: 1 lit, 0 shadowed
layout(binding = 5, rgba32f) uniform writeonly image2D irradiance_image;

// A light of denormals alone does not: a device may take them for 0.
bool shines(LightArgs light) {
    return light.intensity.x >= 1.17549435e-38 || light.intensity.y >= 1.17549435e-38 ||
           light.intensity.z >= 1.17549435e-38;
}

vec4 direct(ivec2 pixel) {
    vec3 x = texelFetch(position_image, pixel, 0).xyz;          TAP(x, x);
    vec4 normal = texelFetch(normal_image, pixel, 0);
    vec3 n = normal.xyz;                                        TAP(n, n);

    precise vec3 irradiance = vec3(0.0);
    precise float lit = 0.0;
    float alpha = 0.0;
    int shining = 0;
    for (int k = 0; k < u.lights; ++k) {
        TAP_SAMPLE(k);
        LightArgs light = lights[k];
        vec3 axis = light.direction;
        precise vec3 e;
        if (light.directional > 0.0) {
            precise float cos_theta = max(0.0, -(n.x * axis.x + n.y * axis.y + n.z * axis.z));
            TAP(cos_theta, cos_theta);
            e = light.intensity * cos_theta;
        } else {
            precise vec3 v = light.position - x;
            precise float d2 = v.x * v.x + v.y * v.y + v.z * v.z;
            precise float inverse = 1.0 / sqrt(max(d2, 1e-37));
            precise vec3 w = v * inverse;                       TAP(w, w);
            precise float cos_theta = max(0.0, n.x * w.x + n.y * w.y + n.z * w.z);
            TAP(cos_theta, cos_theta);
            precise float cos_axis = -(w.x * axis.x + w.y * axis.y + w.z * axis.z);
            precise vec3 intensity = light_intensity(light, cos_axis, d2);
            TAP(intensity, intensity);
            precise float factor = cos_theta * inverse * inverse;
            e = intensity * factor;
        }
        float visibility = texelFetch(visibility_image, ivec3(pixel, k), 0).x;
        TAP(visibility, visibility);
        e = e * visibility;                                     TAP(E, e);
        irradiance += e;
        if (u.density > 0 && shines(light)) {
            lit += visibility;
            ++shining;
        }
    }
    TAP_SAMPLE(-1);
    if (u.density > 0) {
        precise float mean = lit / float(max(shining, 1));
        alpha = normal.w > 0.0 ? mean : 0.0;                    TAP(density, alpha);
    }
    if (u.density > 1) {
        precise float printed = 3.14159274 * alpha;
        irradiance = vec3(printed);
    }
    TAP(irradiance, irradiance);
    return vec4(irradiance, alpha);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    TAP_BEGIN(pixel, 0);
    imageStore(irradiance_image, pixel, direct(pixel));
}
