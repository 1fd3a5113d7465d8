#version 450
// Twin of rsm_kernel.h: one texel of a reflective shadow map (VRSM 4.2, LRA 4.2.2).
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"
#include "raster/light.glsl"
#include "raster/surface.glsl"

layout(std140, binding = 0) uniform RsmUniforms {
    vec4 viewer;
    vec3 eye;
    vec3 forward;
    float pixel_area;   // surface_kernel.h; 0 where no texture has levels
    LightArgs light;
    float texel_scale;  // side of a texel: spot: at depth 1 m, m/m; directional: m
    float half_width;   // half the map's side, in the same unit
} u;

layout(location = 0) flat in int triangle;
layout(location = 1) in vec2 barycentrics;

layout(location = 0) out vec4 position;  // w: linear depth from the light, m
layout(location = 1) out vec4 normal;    // w: 1
layout(location = 2) out vec4 flux;      // W

// Power that the light sends through texel (px, py) to `position`, W.
vec3 texel_power(int px, int py, vec3 position) {
    if (u.light.directional > 0.0) {
        precise float area = u.texel_scale * u.texel_scale;                     TAP(area, area);
        precise vec3 power = u.light.intensity * area;
        return power;
    }
    precise float x = (float(px) + 0.5) * u.texel_scale - u.half_width;
    precise float y = (float(py) + 0.5) * u.texel_scale - u.half_width;
    precise float cos2 = 1.0 / (1.0 + (x * x + y * y));
    precise float cosine = sqrt(cos2);                                         TAP(cos, cosine);
    precise float dw = (u.texel_scale * u.texel_scale) * (cosine * cos2);             TAP(dw, dw);
    precise vec3 d = position - u.light.position;
    precise float d2 = d.x * d.x + d.y * d.y + d.z * d.z;
    vec3 intensity = light_intensity(u.light, cosine, d2);                     TAP(intensity, intensity);
    precise vec3 power = intensity * dw;
    return power;
}

void main() {
    if (masks && is_masked(triangle) && !passes_alpha(triangle, barycentrics)) discard;
    TAP_BEGIN(ivec2(gl_FragCoord.xy), triangle);
    TAP(z, gl_FragCoord.z);
    Surface s = surface(triangle, barycentrics, Viewer(u.viewer, u.forward, u.pixel_area));
    float depth = linear_depth(u.eye, u.forward, s.position);                   TAP(depth, depth);
    vec3 power = texel_power(int(gl_FragCoord.x), int(gl_FragCoord.y), s.position);  TAP(power, power);
    precise vec3 reflected = s.albedo * power;                                    TAP(flux, reflected);
    position = vec4(s.position, depth);
    normal = vec4(s.normal, 1.0);
    flux = vec4(reflected, 0.0);
}
