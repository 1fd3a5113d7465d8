#version 450
// Vertex stage of a layer of the G-buffer; gbuffer_layer.frag is the twin of gbuffer_kernel.h.
#extension GL_GOOGLE_include_directive : require
#include "raster/pull_triangle.glsl"

void main() { pull_triangle(gl_VertexIndex); }
