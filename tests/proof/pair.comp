#version 450
// Twin of PairKernel (stages.h): two outputs of different types, a vector's direction and its length.
layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform PairUniforms {
    int width;
    int height;
} u;
layout(binding = 1) uniform sampler2D vectors_image;
layout(binding = 2, rgba32f) uniform writeonly image2D direction_image;
layout(binding = 3, r32f) uniform writeonly image2D length_image;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    vec4 v = texelFetch(vectors_image, pixel, 0);
    precise float size = sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
    precise vec3 direction = vec3(v.x / size, v.y / size, v.z / size);
    imageStore(direction_image, pixel, vec4(direction, v.w));
    imageStore(length_image, pixel, vec4(size));
}
