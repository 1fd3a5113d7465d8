#version 450
// Twin of level_kernel.h: the level of detail of boxes.
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"
#include "gi/probes/level.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform LevelUniforms {
    int width;       // of the domain: the list, folded to rows
    int height;
    int count;       // boxes
    int levels;      // 1..4
    vec4 eye;        // xyz m
    vec4 forward;    // xyz unit
    vec4 zones;      // cosine, sine of the front's half angle, of the side's
    vec4 scales;     // xyz: front, side, behind
    vec4 distances;  // xyz m: where levels 1, 2, 3 begin
    vec4 margins;    // xyz: what a box's margin is multiplied by at each of them
} u;
layout(std430, binding = 1) readonly buffer Low { vec4 low[]; };    // xyz m; w the margin, m
layout(std430, binding = 2) readonly buffer High { vec4 high[]; };  // xyz m
layout(std430, binding = 3) writeonly buffer LevelOfBoxes { int level[]; };

int level_of_box(int i) {
    vec4 l = low[i];
    vec4 h = high[i];
    precise vec3 from = vec3(l.x - u.eye.x, l.y - u.eye.y, l.z - u.eye.z);
    precise vec3 to = vec3(h.x - u.eye.x, h.y - u.eye.y, h.z - u.eye.z);
    TAP(low, from);
    TAP(high, to);
    precise vec3 gap = vec3(max(max(from.x, 0.0 - to.x), 0.0), max(max(from.y, 0.0 - to.y), 0.0),
                            max(max(from.z, 0.0 - to.z), 0.0));
    precise float distance = sqrt(gap.x * gap.x + gap.y * gap.y + gap.z * gap.z);
    TAP(distance, distance);
    precise vec3 centre = vec3(0.5 * (from.x + to.x), 0.5 * (from.y + to.y), 0.5 * (from.z + to.z));
    precise vec3 half_size = vec3(to.x - centre.x, to.y - centre.y, to.z - centre.z);
    precise float radius = sqrt(half_size.x * half_size.x + half_size.y * half_size.y + half_size.z * half_size.z) +
                           l.w * u.margins.z;
    TAP(radius, radius);
    precise float slack = 1e-5 * (radius + sqrt(centre.x * centre.x + centre.y * centre.y + centre.z * centre.z));
    precise float reach = radius + (0.0 < radius ? slack : 0.0);
    float scale = zone_scale(centre, reach, u.forward.xyz, u.zones, u.scales);
    TAP(scale, scale);
    precise vec3 d = vec3(max(distance - l.w * u.margins.x, 0.0) * scale, max(distance - l.w * u.margins.y, 0.0) * scale,
                          max(distance - l.w * u.margins.z, 0.0) * scale);
    TAP(d, d);
    int own = level_of(d, u.distances, u.levels);
    TAP(level, own);
    return own;
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    int i = at.y * u.width + at.x;
    if (at.x >= u.width || at.y >= u.height || i >= u.count) return;
    TAP_BEGIN(at, 0);
    level[i] = level_of_box(i);
}
