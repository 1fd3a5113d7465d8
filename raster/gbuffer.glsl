// One pixel of the G-buffer, as gbuffer_kernel.h has it. A twin includes it behind its uniform block `u`, whose members
// viewer, eye, forward and pixel_area are read here.
#include "core/tap.glsl"
#include "raster/surface.glsl"

layout(std430, binding = 10) readonly buffer Objects { int objects[]; };  // [triangle]

layout(location = 0) flat in int triangle;
layout(location = 1) in vec2 barycentrics;

layout(location = 0) out vec4 position;  // w: linear eye depth, m
layout(location = 1) out vec4 normal;    // w: 1
layout(location = 2) out vec4 albedo;
layout(location = 3) out vec4 emission;  // W/m2
layout(location = 4) out ivec2 id;       // object, triangle

void write_gbuffer() {
    if (masks && is_masked(triangle) && !passes_alpha(triangle, barycentrics)) discard;
    TAP_BEGIN(ivec2(gl_FragCoord.xy), triangle);
    TAP(object, objects[triangle]);
    TAP(z, gl_FragCoord.z);
    Surface s = surface(triangle, barycentrics, Viewer(u.viewer, u.forward, u.pixel_area));
    float depth = linear_depth(u.eye, u.forward, s.position);  TAP(depth, depth);
    position = vec4(s.position, depth);
    normal = vec4(s.normal, 1.0);
    albedo = vec4(s.albedo, 0.0);
    emission = vec4(s.emission, 0.0);
    id = ivec2(objects[triangle], triangle);
}
