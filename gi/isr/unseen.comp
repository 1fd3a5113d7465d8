#version 450
// Twin of unseen_kernel.h: what an additional camera sees and another view does not.
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"
#include "gi/isr/surface.glsl"
#include "gi/isr/project_to.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform UnseenUniforms {
    SampleUniforms u;
    ViewProjection view;
    float reach;
} block;
layout(binding = 1) uniform sampler2D surface_image;       // xyz unit normal, w depth; all 0: none
layout(binding = 2) uniform sampler2D view_surface_image;
layout(binding = 3, rgba32f) uniform writeonly image2D unseen_image;

vec4 unseen(ivec2 pixel) {
    vec4 texel = texelFetch(surface_image, pixel, 0);
    Surface s = surface_of(block.u, pixel, texel);                TAP(x, s.position);
    Projected p = project_to(block.view, s.position);             TAP(projection, p.position);
    TAP(depth, p.depth);
    CHOICE(int(floor(p.position.x)));
    CHOICE(int(floor(p.position.y)));
    ivec2 there_pixel = ivec2(floor(p.position));                 TAP(pixel, there_pixel);
    bool inside = there_pixel.x >= 0 && there_pixel.x < block.view.width && there_pixel.y >= 0 &&
                  there_pixel.y < block.view.height && p.before;
    TAP(inside, inside);
    vec4 other = texelFetch(view_surface_image, inside ? there_pixel : ivec2(0), 0);
    // The view's image in its own pixels: the margin belongs to it.
    Surface there = surface_of(block.u, there_pixel - ivec2(block.view.margin), other);
    TAP(view_depth, there.depth);
    precise float farthest_seen = there.depth * block.reach;
    bool seen = inside && is_covered(there) && p.depth <= farthest_seen;
    TAP(seen, seen);
    bool kept = is_covered(s) && !seen;
    vec4 result = kept ? texel : vec4(0.0);                       TAP(unseen, result.xyz);
    return result;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= block.u.width || pixel.y >= block.u.height) return;
    TAP_BEGIN(pixel, 0);
    imageStore(unseen_image, pixel, unseen(pixel));
}
