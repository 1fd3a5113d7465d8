#version 450
// Values stored to an image of bytes, for `plumb probe-device`.

layout(local_size_x = 8, local_size_y = 8) in;

layout(std430, binding = 0) readonly buffer Values { vec4 values[]; };  // [row][column]
layout(rgba8, binding = 1) writeonly uniform image2D target;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    imageStore(target, pixel, values[pixel.y * imageSize(target).x + pixel.x]);
}
