#version 450
// Twin of reflect_kernel.h: reflections in what a view sees, LRA 4.2.4 and 4.3.1.
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"
#include "gi/screen/mirrored_ray.glsl"
#include "gi/screen/view.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform ReflectUniforms {
    SeenFrom view;
    vec4 eye;
    float step;
    float thickness;
    float bias;
    int steps;
    int bisections;
    int number;
    int published;
    int width;
    int height;
    int columns;
    int rows;
} u;
layout(binding = 1) uniform sampler2D position_image;  // xyz world, m
layout(binding = 2) uniform sampler2D normal_image;    // xyz unit; all 0: no surface
layout(binding = 3) uniform sampler2D mirror_image;    // w 0: no mirror
layout(binding = 4) uniform sampler2D map_position;    // of the view: xyz world, m; w linear depth, m; 0: nothing
layout(binding = 5) uniform sampler2D map_normal;      // of the view: xyz unit
layout(binding = 6) uniform sampler2D before_image;    // what earlier views found
layout(binding = 7) uniform sampler2D rays_image;      // as screen.lobe writes them
layout(binding = 8, rgba32f) uniform writeonly image2D hit_image;

struct Passed {
    ivec2 texel;
    float behind;
    bool inside;
    bool known;
};

Passed passed_at(MirroredRay ray, float t) {
    precise vec3 x = ray.from_anchor + ray.r * t;
    Place place = place_of(u.view, x);
    vec4 q = texelFetch(map_position, place.inside ? place.texel : ivec2(0), 0);
    precise float behind = place.depth - q.w;
    if (u.published != 0) {
        precise float printed = q.z - (ray.p.z + ray.r.z * t);
        behind = printed;
    }
    TAP(behind, behind);
    return Passed(place.texel, behind, place.inside, place.inside && q.w > 0.0);
}

bool met_at(MirroredRay ray, Passed x, float bias) {
    vec3 q = texelFetch(map_position, x.texel, 0).xyz;
    vec3 n_q = texelFetch(map_normal, x.texel, 0).xyz;
    return may_be_met(ray, q, n_q, bias);
}

Crossing march(MirroredRay ray, bool looking) {
    Crossing c = Crossing(0.0, ivec2(0), 0.0, false);
    bool in_front = true;
    bool entered = false;
    for (int i = 1; looking && i <= u.steps; ++i) {
        TAP_SAMPLE(i);
        precise float t = float(i) * u.step;                      TAP(t, t);
        Passed x = passed_at(ray, t);
        bool behind = x.known && x.behind >= 0.0;
        bool crossed = behind && in_front && x.behind <= u.thickness;
        if (u.published != 0) {
            precise float printed = ray.r.z * u.step + x.behind;
            crossed = behind && printed < u.thickness;
        } else if (crossed) {
            crossed = met_at(ray, x, u.bias);
        }
        TAP(crossed, crossed);
        if (crossed) c = Crossing(t, x.texel, x.behind, true);
        // A ray that has left the view does not come back.
        looking = !crossed && (x.inside || !entered);
        entered = entered || x.inside;
        in_front = !behind;
    }
    TAP_SAMPLE(-1);
    return c;
}

Crossing bisected(MirroredRay ray, Crossing c) {
    precise float t = c.t;
    precise float length = u.step;
    bool behind = true;
    for (int k = 0; c.found && k < u.bisections; ++k) {
        TAP_SAMPLE(u.steps + 1 + k);
        length = length * 0.5;
        t = behind ? t - length : t + length;                     TAP(t, t);
        Passed x = passed_at(ray, t);
        behind = x.known && x.behind >= 0.0;
        if (u.published == 0 && behind) behind = met_at(ray, x, 0.0);
        if (u.published != 0 || behind) c = Crossing(t, x.texel, x.behind, true);
    }
    TAP_SAMPLE(-1);
    return c;
}

vec4 reflect_at(ivec2 item) {
    ivec2 pixel = u.rows > 0 ? ivec2(item.x % u.columns, item.y % u.rows) : item;
    vec3 p = texelFetch(position_image, pixel, 0).xyz;            TAP(p, p);
    vec3 n = texelFetch(normal_image, pixel, 0).xyz;              TAP(n, n);
    precise vec3 to_p = p - u.eye.xyz;
    MirroredRay ray = mirrored_ray(p, n, u.published != 0 ? u.eye.xyz : to_p, u.view.anchor.xyz);
    vec4 before = texelFetch(before_image, item, 0);
    precise float n2 = n.x * n.x + n.y * n.y + n.z * n.z;
    bool leaves = u.published != 0 ? n2 > 0.0 : ray.cosine < 0.0;
    bool starts = leaves && texelFetch(mirror_image, pixel, 0).w > 0.0;
    if (u.rows > 0) starts = take_drawn(texelFetch(rays_image, item, 0), ray);
    Crossing c = bisected(ray, march(ray, starts && before.w != 1.0));
    if (u.published == 0) c.found = c.found && c.behind <= u.thickness;
    return nearer_hit(before, c, u.number);
}

void main() {
    ivec2 item = ivec2(gl_GlobalInvocationID.xy);
    if (item.x >= u.width || item.y >= u.height) return;
    TAP_BEGIN(item, 0);
    imageStore(hit_image, item, reflect_at(item));
}
