#version 450
// project() of one point a pixel, with its choices stored as a twin stores them that is compiled with PLUMB_CHOICES.
#extension GL_GOOGLE_include_directive : require
#define PLUMB_CHOICES
#include "core/tap.glsl"
#include "raster/project.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std430, binding = 0) readonly buffer Map { Projection map; };
layout(std430, binding = 1) readonly buffer Points { vec4 points[]; };  // [height][width]
layout(std430, binding = 2) writeonly buffer Texels { ivec2 texels[]; };

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= choices_width || pixel.y >= points.length() / choices_width) return;
    TAP_BEGIN(pixel, 0);
    int at = pixel.y * choices_width + pixel.x;
    texels[at] = project(map, points[at].xyz);
}
