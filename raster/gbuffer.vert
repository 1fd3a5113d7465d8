#version 450
// Vertex stage of the G-buffer pass; gbuffer.frag is the twin of gbuffer_kernel.h.
#extension GL_GOOGLE_include_directive : require
#include "raster/pull_triangle.glsl"

void main() { pull_triangle(gl_VertexIndex); }
