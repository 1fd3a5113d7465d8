#version 450
// Twin of nearest_kernel.h: the least depths of blocks of texels.
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform NearestUniforms {
    int width;
    int height;
    int view_width;
    int view_height;
    int levels;
    int padded;
} u;
layout(binding = 1) uniform sampler2D map_position;  // w linear depth, m; 0: nothing
layout(binding = 2, rgba32f) uniform writeonly image2D nearest_image;

vec4 nearest(ivec2 pixel) {
    int side = 2;
    int row = pixel.y;
    for (int l = 2; l <= u.levels; ++l) {
        int start = u.padded - (2 * u.padded >> l);
        bool beyond = pixel.y >= start;
        side = beyond ? 1 << l : side;
        row = beyond ? pixel.y - start : row;
    }
    TAP(side, float(side));
    float least = 3e38;
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            ivec2 at = ivec2(pixel.x * side + x, row * side + y);
            bool inside = at.x < u.view_width && at.y < u.view_height;
            float depth = texelFetch(map_position, inside ? at : ivec2(0), 0).w;
            if (inside && depth > 0.0) least = min(least, depth);
        }
    TAP(least, least);
    return vec4(least, 0.0, 0.0, 0.0);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    TAP_BEGIN(pixel, 0);
    imageStore(nearest_image, pixel, nearest(pixel));
}
