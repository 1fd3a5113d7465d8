#version 450
// Twin of StepKernel (stages.h): one step of x = b + rho mean(x), the mean of the four neighbours.
layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform StepUniforms {
    int width;
    int height;
    float rho;
} u;
layout(binding = 1) uniform sampler2D source_image;
layout(binding = 2) uniform sampler2D before_image;
layout(binding = 3, rgba32f) uniform writeonly image2D after_image;

vec4 at(int x, int y) { return texelFetch(before_image, ivec2(clamp(x, 0, u.width - 1), clamp(y, 0, u.height - 1)), 0); }

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    vec4 b = texelFetch(source_image, pixel, 0);
    vec4 l = at(pixel.x - 1, pixel.y), r = at(pixel.x + 1, pixel.y), t = at(pixel.x, pixel.y - 1), d = at(pixel.x, pixel.y + 1);
    precise vec3 mean = vec3(0.25 * (l.x + r.x + t.x + d.x), 0.25 * (l.y + r.y + t.y + d.y), 0.25 * (l.z + r.z + t.z + d.z));
    precise vec3 x = vec3(b.x + u.rho * mean.x, b.y + u.rho * mean.y, b.z + u.rho * mean.z);
    imageStore(after_image, pixel, vec4(x, b.w));
}
