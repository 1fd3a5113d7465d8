#version 450
// Twin of ssao_kernel.h: ambient occlusion by what the camera sees, ISR (26) corrected or as printed.
#extension GL_GOOGLE_include_directive : require
#include "core/hash.glsl"
#include "core/tap.glsl"
#include "gi/isr/surface.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform SampleUniformBlock { SampleUniforms u; };
layout(binding = 1) uniform sampler2D surface_image;         // xyz unit normal, w depth; all 0: none
layout(binding = 2) uniform sampler2D source_surface_image;
layout(binding = 3) uniform sampler2D gathered_image;        // xyz W/m2
layout(std430, binding = 4) readonly buffer Offsets { int offsets[]; };  // [samples][rotations]
layout(binding = 5, rgba32f) uniform writeonly image2D lit_image;

struct Sphere {
    vec3 position;
    float radius2;
};

Sphere sphere_of(ivec2 pixel, vec4 texel) {
    Surface s = surface_of(u, pixel, texel);
    precise float radius2 = (u.area * s.depth) * s.depth;
    return Sphere(s.position, radius2);
}

#include "gi/isr/rotation.glsl"

// Beyond the border there is no surface.
Sphere sphere_at(ivec2 pixel, int rotation, int k) {
    ivec2 offset = offset_of(offsets[rotation + k * u.rotations]);
    ivec2 texel = pixel + offset + ivec2(u.margin);               TAP(texel, texel);
    bool inside = texel.x >= 0 && texel.x < u.source_width && texel.y >= 0 && texel.y < u.source_height;
    TAP(inside, inside);
    vec4 surface = inside ? texelFetch(source_surface_image, inside ? texel : ivec2(0), 0) : vec4(0.0);
    return sphere_of(pixel + offset, surface);
}

float occlusion_of(Surface p, Sphere x) {
    precise vec3 d = x.position - p.position;
    precise float d2 = d.x * d.x + d.y * d.y + d.z * d.z;
    precise float distance = sqrt(max(d2, least_distance2));      TAP(distance, distance);
    precise float cos_p = max(0.0, p.normal.x * d.x + p.normal.y * d.y + p.normal.z * d.z);
    TAP(cos_p, cos_p);
    precise float inverse = 1.0 / distance;
    precise float ratio = min(1.0, (x.radius2 * inverse) * inverse);              TAP(ratio, ratio);
    // 1 - sqrt(1 - ratio), without its cancellation.
    precise float cap = ratio / (1.0 + sqrt(1.0 - ratio));
    float per_length = u.published != 0 && u.per_length > 0.0 ? u.per_length : inverse;
    precise float cosine = cos_p * per_length;
    precise float printed = cap * cosine;
    precise float corrected = ratio * cosine;
    float occlusion = u.published != 0 ? printed : corrected;     TAP(occlusion, occlusion);
    return occlusion;
}

float accessibility_by(Surface p, ivec2 pixel, int rotation) {
    bool covered = is_covered(p);
    precise float sum = 0.0;
    int samples = 4 * u.rings * (u.rings + 1);
    for (int k = 0; covered && k < samples; ++k) {
        TAP_SAMPLE(k);
        Sphere x = sphere_at(pixel, rotation, k);
        TAP(x, x.position);
        sum += occlusion_of(p, x);
    }
    TAP_SAMPLE(-1);
    precise float scaled = sum * u.scale;
    float occlusion = u.published != 0 ? scaled : sum;            TAP(sum, occlusion);
    precise float open = 1.0 - occlusion;
    float accessibility = covered ? min(max(open, 0.0), 1.0) : 1.0;               TAP(accessibility, accessibility);
    return accessibility;
}

vec4 ssao(ivec2 pixel) {
    Surface p = surface_of(u, pixel, texelFetch(surface_image, pixel, 0));
    TAP(p, p.position);
    TAP(n_p, p.normal);
    float accessibility = accessibility_by(p, pixel, rotation_of(pixel));
    vec3 gathered = texelFetch(gathered_image, pixel, 0).xyz;
    return vec4(is_covered(p) ? gathered : vec3(0.0), accessibility);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    TAP_BEGIN(pixel, 0);
    imageStore(lit_image, pixel, ssao(pixel));
}
