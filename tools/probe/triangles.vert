#version 450
// Clip positions as they come, three a triangle, for `plumb probe-device`.

layout(location = 0) in vec4 clip_position;
layout(location = 0) flat out int triangle;
layout(location = 1) out vec2 barycentrics;  // l1, l2

void main() {
    triangle = gl_VertexIndex / 3;
    int corner = gl_VertexIndex - triangle * 3;
    barycentrics = vec2(corner == 1 ? 1.0 : 0.0, corner == 2 ? 1.0 : 0.0);
    gl_Position = clip_position;
}
