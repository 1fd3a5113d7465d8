#version 450
// A filtered texture at given places, for `plumb probe-device`.

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0) uniform sampler2D texels;
layout(std430, binding = 1) readonly buffer Places { vec2 places[]; };    // [row][column]
layout(std430, binding = 2) writeonly buffer Results { vec4 results[]; };  // [row][column]

const uint columns = 256;

void main() {
    uint i = gl_GlobalInvocationID.y * columns + gl_GlobalInvocationID.x;
    results[i] = textureLod(texels, places[i], 0.0);
}
