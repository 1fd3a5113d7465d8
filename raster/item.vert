#version 450
// Vertex stage of the item buffers: item.frag.
#extension GL_GOOGLE_include_directive : require
#include "raster/pull_triangle.glsl"

void main() { pull_triangle(gl_VertexIndex); }
