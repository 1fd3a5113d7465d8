#version 450
// Twin of gather_camera_kernel.h: light that surfaces send which only an additional camera sees.
#extension GL_GOOGLE_include_directive : require
#include "core/hash.glsl"
#include "core/tap.glsl"
#include "gi/isr/surface.glsl"
#include "gi/isr/project_to.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform GatherCameraUniforms {
    SampleUniforms u;
    SampleUniforms camera;
    ViewProjection view;
    vec4 camera_eye;
};
layout(binding = 1) uniform sampler2D surface_image;           // xyz unit normal, w depth; all 0: none
layout(binding = 2) uniform sampler2D source_surface_image;
layout(binding = 3) uniform sampler2D source_radiosity_image;  // xyz W/m2
layout(binding = 4) uniform sampler2D before_image;            // what other sources sent
layout(std430, binding = 5) readonly buffer Offsets { int offsets[]; };  // [samples][rotations]
layout(std430, binding = 6) readonly buffer Weights { float weights[]; };  // [samples]
layout(binding = 7, rgba32f) uniform writeonly image2D gathered_image;

#include "gi/isr/source.glsl"

// Where the receiver projects to in the camera's image, and whether it lies before the camera.
ivec2 centre;
bool before_camera;

void look_at_receiver(vec3 x) {
    Projected p = project_to(view, x);                            TAP(projection, p.position);
    CHOICE(int(floor(p.position.x)));
    CHOICE(int(floor(p.position.y)));
    centre = ivec2(floor(p.position));                            TAP(centre, centre);
    before_camera = p.before;                                     TAP(before, before_camera);
}

// Beyond the border there is no surface.
Source source_at(ivec2 pixel, int rotation, int k, Surface p) {
    ivec2 offset = offset_of(offsets[rotation + k * u.rotations]);
    ivec2 texel = centre + offset;                                TAP(texel, texel);
    bool inside = texel.x >= 0 && texel.x < camera.width && texel.y >= 0 && texel.y < camera.height && before_camera;
    TAP(inside, inside);
    ivec2 fetched = inside ? texel : ivec2(0);
    vec4 surface = inside ? texelFetch(source_surface_image, fetched, 0) : vec4(0.0);
    Surface s = surface_of(camera, texel, surface);
    precise vec3 x = s.position + camera_eye.xyz;
    precise vec3 to = x - p.position;
    return Source(to, area_of(camera, s), weights[k] == 0.0 ? 1.0 : weights[k], s.normal,
                  light_of(s, texelFetch(source_radiosity_image, fetched, 0).xyz));
}

#include "gi/isr/gather_by.glsl"

vec4 gather_camera(ivec2 pixel) {
    Surface p = surface_of(u, pixel, texelFetch(surface_image, pixel, 0));
    TAP(p, p.position);
    TAP(n_p, p.normal);
    vec4 before = texelFetch(before_image, pixel, 0);
    int rotation = rotation_of(pixel);
    look_at_receiver(p.position);
    return gather_by(p, before, 0.0, pixel, rotation);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    TAP_BEGIN(pixel, 0);
    imageStore(gathered_image, pixel, gather_camera(pixel));
}
