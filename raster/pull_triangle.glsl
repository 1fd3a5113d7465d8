// The vertex stage of every pass: three vertices a triangle, without an index buffer. Clip positions are the host's
// (clip_positions() in screen_triangle.h: double, rounded once), so that a device and this project snap the same
// numbers.

layout(std430, binding = 2) readonly buffer Triangles { int triangles[]; };             // [triangle][3]
layout(std430, binding = 9) readonly buffer ClipPositions { vec4 clip_positions[]; };  // [vertex]

layout(location = 0) flat out int triangle;
layout(location = 1) out vec2 barycentrics;  // l1, l2

void pull_triangle(int index) {
    triangle = index / 3;
    int corner = index - triangle * 3;
    barycentrics = vec2(corner == 1 ? 1.0 : 0.0, corner == 2 ? 1.0 : 0.0);
    gl_Position = clip_positions[triangles[index]];
}
