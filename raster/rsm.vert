#version 450
// Vertex stage of the reflective shadow map; rsm.frag is the twin of rsm_kernel.h.
#extension GL_GOOGLE_include_directive : require
#include "raster/pull_triangle.glsl"

void main() { pull_triangle(gl_VertexIndex); }
