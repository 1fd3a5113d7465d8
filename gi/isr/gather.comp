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
layout(binding = 6, rgba32f) uniform writeonly image2D gathered_image;

struct Source {
    vec3 position;
    float area;
    vec3 normal;
    vec3 radiosity;
};

// No light is brighter than this, W/m2: infinity times a form factor of 0 would be no number.
const float brightest = 1e30;

Source source_of(ivec2 pixel, vec4 texel, vec3 radiosity) {
    Surface s = surface_of(u, pixel, texel);
    vec3 bounded = vec3(min(radiosity.x, brightest), min(radiosity.y, brightest), min(radiosity.z, brightest));
    return Source(s.position, area_of(u, s), s.normal, is_covered(s) ? bounded : vec3(0.0));
}

int rotation_of(ivec2 pixel) {
    return int(pixel_hash(uint(pixel.x), uint(pixel.y), 0u, u.seed).x >> 16) & (u.rotations - 1);
}

// Beyond the border there is no surface.
Source source_at(ivec2 pixel, int rotation, int k) {
    ivec2 offset = offset_of(offsets[rotation + k * u.rotations]);
    ivec2 texel = pixel + offset + ivec2(u.margin);               TAP(texel, texel);
    bool inside = texel.x >= 0 && texel.x < u.source_width && texel.y >= 0 && texel.y < u.source_height;
    TAP(inside, inside);
    ivec2 fetched = inside ? texel : ivec2(0);
    vec4 surface = inside ? texelFetch(source_surface_image, fetched, 0) : vec4(0.0);
    return source_of(pixel + offset, surface, texelFetch(source_radiosity_image, fetched, 0).xyz);
}

// F_pX.
float form_factor(vec3 x_p, vec3 n_p, Source x) {
    precise vec3 d = x.position - x_p;
    precise float d2 = max(d.x * d.x + d.y * d.y + d.z * d.z, least_distance2);    TAP(d2, d2);
    precise float cos_p = max(0.0, n_p.x * d.x + n_p.y * d.y + n_p.z * d.z);       TAP(cos_p, cos_p);
    precise float cos_x = max(0.0, -(x.normal.x * d.x + x.normal.y * d.y + x.normal.z * d.z));
    TAP(cos_x, cos_x);
    precise float cosines = cos_p * (1.0 / d2) * cos_x;
    precise float pi_d2 = 3.14159265 * d2;
    precise float divisor = u.published != 0 ? pi_d2 : pi_d2 + x.area;
    precise float form = cosines * (x.area / divisor);                             TAP(form, form);
    return form;
}

vec4 gather_by(Surface p, vec4 before, float mask, ivec2 pixel, int rotation) {
    bool covered = is_covered(p);
    bool published = u.published != 0;
    float largest = published ? 1.0 : max(1.0, before.w);
    precise vec3 started = vec3(before.x * largest, before.y * largest, before.z * largest);
    precise vec3 sum = published ? vec3(0.0) : started;
    precise float forms = before.w;
    int k = 0;
    for (int ring = 1; ring <= u.rings; ++ring) {
        // ISR chapter 6: fewer samples for pixels far away.
        float reach = ring <= u.far_rings ? 3.4e38 : u.full_reach;
        precise float at_ring = float(ring) * p.depth;
        if (!(covered && at_ring <= reach)) break;
        for (int i = 0; i < 8 * ring; ++i, ++k) {
            TAP_SAMPLE(k);
            Source x = source_at(pixel, rotation, k);
            TAP(x, x.position);
            TAP(n_x, x.normal);
            TAP(area, x.area);
            TAP(radiosity, x.radiosity);
            precise float form = form_factor(p.position, p.normal, x);
            sum.x += form * x.radiosity.x;
            sum.y += form * x.radiosity.y;
            sum.z += form * x.radiosity.z;
            forms += form;                                        TAP(forms, forms);
        }
    }
    TAP_SAMPLE(-1);
    precise float by_mask = mask * u.scale;
    precise float by_forms = 1.0 / max(1.0, forms);
    float share = published ? by_mask : by_forms;
    precise vec3 light = sum * share;
    if (published) light = light + before.xyz;
    vec3 irradiance = covered ? light : vec3(0.0);                TAP(irradiance, irradiance);
    return vec4(irradiance, covered ? forms : 0.0);
}

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
