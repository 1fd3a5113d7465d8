#version 450
// Twin of gather_kernel.h: one bounce of diffuse light between what the camera sees, ISR (25) corrected or as printed.
#extension GL_GOOGLE_include_directive : require
#include "core/hash.glsl"
#include "core/tap.glsl"
#include "gi/isr/surface.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform SampleUniformBlock { SampleUniforms u; };
layout(binding = 1) uniform sampler2D surface_image;           // xyz unit normal, w depth; all 0: none
layout(binding = 2) uniform sampler2D source_surface_image;
layout(binding = 3) uniform sampler2D source_radiosity_image;  // xyz W/m2, w radiation mask
layout(binding = 4) uniform sampler2D before_image;            // what other sources sent
layout(std430, binding = 5) readonly buffer Offsets { int offsets[]; };  // [samples][rotations]
layout(std430, binding = 6) readonly buffer Weights { float weights[]; };  // [samples]
layout(binding = 7, rgba32f) uniform writeonly image2D gathered_image;

#include "gi/isr/source.glsl"

// Beyond the border there is no surface.
Source source_at(ivec2 pixel, int rotation, int k, Surface p) {
    ivec2 offset = offset_of(offsets[rotation + k * u.rotations]);
    ivec2 texel = pixel + offset + ivec2(u.margin);               TAP(texel, texel);
    bool inside = texel.x >= 0 && texel.x < u.source_width && texel.y >= 0 && texel.y < u.source_height;
    TAP(inside, inside);
    ivec2 fetched = inside ? texel : ivec2(0);
    vec4 surface = inside ? texelFetch(source_surface_image, fetched, 0) : vec4(0.0);
    Surface s = surface_of(u, pixel + offset, surface);
    vec3 step = step_of(float(offset.x), float(offset.y));
    return Source(between(p, step, s.depth), area_of(u, s), weights[k] == 0.0 ? 1.0 : weights[k], s.normal,
                  light_of(s, texelFetch(source_radiosity_image, fetched, 0).xyz));
}

#include "gi/isr/gather_by.glsl"

vec4 gather(ivec2 pixel) {
    Surface p = surface_of(u, pixel, texelFetch(surface_image, pixel, 0));
    TAP(p, p.position);
    TAP(n_p, p.normal);
    vec4 before = texelFetch(before_image, pixel, 0);
    float mask = u.published != 0 ? texelFetch(source_radiosity_image, pixel + ivec2(u.margin), 0).w : 0.0;
    return gather_by(p, before, mask, pixel, rotation_of(pixel));
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    TAP_BEGIN(pixel, 0);
    imageStore(gathered_image, pixel, gather(pixel));
}
