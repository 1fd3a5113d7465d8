#version 450
// Twin of radiance_kernel.h: the radiance that a probe's relight rays bring.
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"
#include "gi/probes/lightmap_levels.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform RadianceUniforms {
    int width;       // rays of a probe
    int height;      // probes
    int side;        // of the lightmap, texels
    int levels;      // of detail
    int feedback;    // 0: rho / pi, 1: constant, 2: rho
    float constant;  // 1/sr
} u;
layout(std430, binding = 1) readonly buffer Surface { vec4 surface[]; };  // xyz reflectance; w 1: has a place on the lightmap
layout(std430, binding = 2) readonly buffer Emitted { vec4 emitted[]; };  // W/(m2 sr)
layout(std430, binding = 3) readonly buffer Direct { vec4 direct[]; };    // W/m2
layout(std430, binding = 4) readonly buffer Place { vec4 place[]; };      // xy of the lightmap, z its level
layout(binding = 5) uniform sampler2D lightmap;                           // W/m2
layout(std430, binding = 6) writeonly buffer Radiance { vec4 radiance[]; };

vec4 brought_by(int at) {
    vec3 rho = surface[at].xyz;                                   TAP(rho, rho);
    bool reflects = surface[at].w > 0.0;                          TAP(reflects, reflects);
    vec3 own = emitted[at].xyz;                                   TAP(emitted, own);
    vec3 by_lights = direct[at].xyz;                              TAP(direct, by_lights);
    int level = max(0, min(int(place[at].z), u.levels - 1));      TAP(level, level);
    vec3 indirect = lightmap_at(lightmap, u.side, u.levels, place[at].xy, level);
    TAP(indirect, indirect);
    precise vec3 diffuse = rho * 0.318309886;
    vec3 share = diffuse;
    if (u.feedback == 1) share = vec3(u.constant);
    if (u.feedback == 2) share = rho;
    TAP(share, share);
    precise vec3 f = own + (diffuse * by_lights + share * indirect);
    vec3 brought = reflects ? f : own;                            TAP(f, brought);
    return vec4(brought, 0.0);
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (at.x >= u.width || at.y >= u.height) return;
    TAP_BEGIN(at, 0);
    int item = at.y * u.width + at.x;
    radiance[item] = brought_by(item);
}
