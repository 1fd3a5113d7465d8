#version 450
// Values written to a colour target, for `plumb probe-device`.

layout(std430, binding = 0) readonly buffer Values { vec4 values[]; };  // [row][column]

layout(location = 0) out vec4 colour;

const int columns = 256;

void main() {
    colour = values[int(gl_FragCoord.y) * columns + int(gl_FragCoord.x)];
}
