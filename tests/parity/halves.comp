#version 450
// half_of() of each number.
#extension GL_GOOGLE_include_directive : require
#include "tools/mutants/prelude.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std430, binding = 0) readonly buffer Numbers { float numbers[]; };  // [rows][256]
layout(std430, binding = 1) writeonly buffer Halves { int halves[]; };

void main() {
    int at = int(gl_GlobalInvocationID.y) * 256 + int(gl_GlobalInvocationID.x);
    if (at < numbers.length()) halves[at] = floatBitsToInt(half_of(numbers[at]));
}
