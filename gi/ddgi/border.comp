#version 450
// Twin of border_kernel.h: the gutter of octahedral tiles.
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform BorderUniforms {
    int width;   // of the atlas, texels
    int height;
    int side;    // of a tile, without its gutter
} u;
layout(binding = 1) uniform sampler2D atlas;  // the gutter holds anything
layout(binding = 2, rgba32f) uniform writeonly image2D bordered_image;

vec4 border(ivec2 pixel) {
    ivec2 tile = pixel / (u.side + 2);
    ivec2 texel = pixel - tile * (u.side + 2);
    bool beside_x = texel.x < 1 || texel.x > u.side;
    bool beside_y = texel.y < 1 || texel.y > u.side;
    int x = max(1, min(texel.x, u.side));
    int y = max(1, min(texel.y, u.side));
    ivec2 from = ivec2(beside_y ? u.side + 1 - x : x, beside_x ? u.side + 1 - y : y);
    TAP(from, from);
    int row = min(tile.y * (u.side + 2) + from.y, u.height - 1);
    int column = min(tile.x * (u.side + 2) + from.x, u.width - 1);
    return texelFetch(atlas, ivec2(column, row), 0);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    TAP_BEGIN(pixel, 0);
    imageStore(bordered_image, pixel, border(pixel));
}
