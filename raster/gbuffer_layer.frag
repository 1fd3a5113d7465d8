#version 450
// Twin of gbuffer_kernel.h for a layer behind another (ISR ch. 6; Everitt 2001, depth peeling): what does not lie strictly
// farther than the layer before is not drawn.
#extension GL_GOOGLE_include_directive : require

layout(std140, binding = 0) uniform GBufferLayerUniforms {
    vec4 viewer;
    vec3 eye;
    float farther;     // 1; reversed z: -1
    vec3 forward;
    float pixel_area;  // surface_kernel.h; 0 where no texture has levels
} u;
layout(binding = 11) uniform sampler2D behind_image;  // z of the depth buffer
#include "raster/gbuffer.glsl"

void main() {
    // Written so that NaN does not pass.
    float peeled = texelFetch(behind_image, ivec2(gl_FragCoord.xy), 0).x;
    precise float own = u.farther * gl_FragCoord.z, before = u.farther * peeled;
    if (!(own > before)) discard;
    write_gbuffer();
}
