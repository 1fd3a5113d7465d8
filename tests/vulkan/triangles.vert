#version 450
// Clip positions as they come; every triangle has its number.

layout(location = 0) in vec4 clip_position;
layout(location = 0) flat out float number;

void main() {
    gl_Position = clip_position;
    number = float(gl_VertexIndex / 3);
}
