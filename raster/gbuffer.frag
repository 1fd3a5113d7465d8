#version 450
// Twin of gbuffer_kernel.h: one pixel of the G-buffer (ISR 4.2, VRSM 4.2).
#extension GL_GOOGLE_include_directive : require

layout(std140, binding = 0) uniform GBufferUniforms {
    vec4 viewer;
    vec3 eye;
    vec3 forward;
    float pixel_area;  // surface_kernel.h; 0 where no texture has levels
} u;
#include "raster/gbuffer.glsl"

void main() { write_gbuffer(); }
