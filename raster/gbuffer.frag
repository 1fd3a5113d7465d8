#version 450
// Twin of gbuffer_kernel.h: one pixel of the G-buffer (ISR 4.2, VRSM 4.2).
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"
#include "raster/surface.glsl"

layout(std140, binding = 0) uniform GBufferUniforms {
    vec4 viewer;
    vec3 eye;
    vec3 forward;
    float pixel_area;  // surface_kernel.h; 0 where no texture has levels
} u;
layout(std430, binding = 10) readonly buffer Objects { int objects[]; };  // [triangle]

layout(location = 0) flat in int triangle;
layout(location = 1) in vec2 barycentrics;

layout(location = 0) out vec4 position;  // w: linear eye depth, m
layout(location = 1) out vec4 normal;    // w: 1
layout(location = 2) out vec4 albedo;
layout(location = 3) out vec4 emission;  // W/m2
layout(location = 4) out ivec2 id;       // object, triangle

void main() {
    if (masks && is_masked(triangle) && !passes_alpha(triangle, barycentrics)) discard;
    TAP_BEGIN(ivec2(gl_FragCoord.xy), triangle);
    TAP(object, objects[triangle]);
    TAP(z, gl_FragCoord.z);
    Surface s = surface(triangle, barycentrics, Viewer(u.viewer, u.forward, u.pixel_area));
    float depth = linear_depth(u.eye, u.forward, s.position);  TAP(depth, depth);
    position = vec4(s.position, depth);
    normal = vec4(s.normal, 1.0);
    albedo = vec4(s.albedo, 0.0);
    emission = vec4(s.emission, 0.0);
    id = ivec2(objects[triangle], triangle);
}
