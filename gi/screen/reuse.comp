#version 450
// Twin of reuse_kernel.h: indirect light of frames before this one, read where its surface was seen then.
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"
#include "gi/filter/weights.glsl"
#include "gi/screen/view.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform ReuseUniforms {
    SeenFrom last;
    SeenFrom now;
    float most;          // N
    float least_weight;
    float sigma_depth;
    float normal_slope;
    float normal_offset;
    int clamps;
    int there;           // 0: there is no last frame
    int width;
    int height;
} u;
layout(binding = 1) uniform sampler2D irradiance_image;  // E, W/m2
layout(binding = 2) uniform sampler2D position_image;    // xyz world, m; w linear depth, m
layout(binding = 3) uniform sampler2D normal_image;      // xyz unit; all 0: no surface
layout(binding = 4) uniform sampler2D last_irradiance;   // H_k, W/m2
layout(binding = 5) uniform sampler2D last_age;          // x m_k; w 1 on a surface
layout(binding = 6) uniform sampler2D last_position;
layout(binding = 7) uniform sampler2D last_normal;
layout(binding = 8, rgba32f) uniform writeonly image2D reused_image;
layout(binding = 9, rgba32f) uniform writeonly image2D age_image;

struct Before {
    vec3 irradiance;
    float frames;
    float weight;
};

// Where a point falls in a view's image, in its pixels; z depth.
vec3 image_of(SeenFrom view, vec3 p) {
    precise vec3 v = p - view.anchor.xyz;
    precise float depth = view.forward.x * v.x + view.forward.y * v.y + view.forward.z * v.z + view.forward.w;
    float divisor = view.perspective > 0.0 ? max(depth, view.least_depth) : 1.0;
    precise float row_x = view.to_x.x * v.x + view.to_x.y * v.y + view.to_x.z * v.z + view.to_x.w;
    precise float row_y = view.to_y.x * v.x + view.to_y.y * v.y + view.to_y.z * v.z + view.to_y.w;
    precise vec3 at = vec3(row_x / divisor, row_y / divisor, depth);
    return at;
}

// What the last frame had of a point.
Before before_of(ivec2 here, vec4 p, vec3 n, bool covered) {
    vec3 was = image_of(u.last, p.xyz);
    vec3 is = image_of(u.now, p.xyz);
    TAP(depth, was.z);
    precise vec2 moved = was.xy - is.xy;                          TAP(moved, moved);
    precise vec2 sum = vec2(here) + moved;
    vec2 at = min(max(sum, vec2(-65536.0)), vec2(65536.0));
    CHOICE(int(floor(at.x)));
    CHOICE(int(floor(at.y)));
    ivec2 first = ivec2(floor(at));                               TAP(pixel, first);
    precise vec2 share = at - vec2(first);
    bool there = covered && (!(u.last.perspective > 0.0) || was.z >= u.last.least_depth);
    Centre own = centre_of(p.xyz, p.w, n, u.sigma_depth, u.normal_slope);
    precise vec3 irradiance = vec3(0.0);
    precise float frames = 0.0;
    precise float total = 0.0;
    for (int k = 0; k < 4; ++k) {
        TAP_SAMPLE(k);
        ivec2 pixel = first + ivec2(k & 1, k >> 1);
        bool inside = there && pixel.x >= 0 && pixel.x < u.last.width && pixel.y >= 0 && pixel.y < u.last.height;
        pixel = inside ? pixel : ivec2(0);
        vec4 q = texelFetch(last_position, pixel, 0);
        vec4 age = texelFetch(last_age, pixel, 0);
        vec3 m = texelFetch(last_normal, pixel, 0).xyz;
        vec3 h = texelFetch(last_irradiance, pixel, 0).xyz;
        TAP(last, h);
        precise float share_x = (k & 1) != 0 ? share.x : 1.0 - share.x;
        precise float share_y = k > 1 ? share.y : 1.0 - share.y;
        precise float bilinear = share_x * share_y;
        float of_depth = depth_weight(true, own, q.xyz, q.w);
        float of_normal = normal_weight(own, m, u.normal_offset);
        precise float product = bilinear * of_depth * of_normal;
        float weight = inside && age.w > 0.0 ? product : 0.0;
        TAP(weight, weight);
        irradiance += weight * h;
        frames += weight * age.x;
        total += weight;
    }
    TAP_SAMPLE(-1);
    return Before(irradiance, frames, total);
}

struct Box {
    vec3 low;
    vec3 high;
};

// What the 3 x 3 pixels about one have now.
Box box_of(ivec2 pixel, vec3 e) {
    Box box = Box(e, e);
    for (int k = 0; k < 9; ++k) {
        ivec2 at = min(max(pixel + ivec2(k % 3 - 1, k / 3 - 1), ivec2(0)), ivec2(u.width - 1, u.height - 1));
        vec3 n = texelFetch(normal_image, at, 0).xyz;
        vec3 o = texelFetch(irradiance_image, at, 0).xyz;
        precise float n2 = n.x * n.x + n.y * n.y + n.z * n.z;
        if (n2 > 0.0) box = Box(min(box.low, o), max(box.high, o));
    }
    return box;
}

void reuse(ivec2 at) {
    vec4 p = texelFetch(position_image, at, 0);                   TAP(p, p.xyz);
    vec3 n = texelFetch(normal_image, at, 0).xyz;                 TAP(n, n);
    vec3 e = texelFetch(irradiance_image, at, 0).xyz;             TAP(e, e);
    precise float n2 = n.x * n.x + n.y * n.y + n.z * n.z;
    bool covered = n2 > 0.0;
    Before last = Before(vec3(0.0), 0.0, 0.0);
    if (u.there != 0) last = before_of(at, p, n, covered);
    TAP(total, last.weight);
    bool known = last.weight > u.least_weight;                    TAP(known, known);
    float total = known ? last.weight : 1.0;
    precise vec3 h = last.irradiance / total;                     TAP(h, h);
    Box box = box_of(at, e);
    vec3 held = min(max(h, box.low), box.high);                   TAP(held, held);
    precise vec3 apart = h - held;
    precise float sum = abs(apart.x) + abs(apart.y) + abs(apart.z);
    float off = known ? sum : 0.0;                                TAP(ghost, off);
    vec3 history = u.clamps != 0 ? held : h;
    precise float older = last.frames / total + 1.0;
    float frames = known ? min(older, u.most) : 1.0;              TAP(frames, frames);
    precise vec3 mean = history + (e - history) / frames;
    vec3 light = covered ? (known ? mean : e) : vec3(0.0);        TAP(reused, light);
    imageStore(reused_image, at, vec4(light, p.w));
    imageStore(age_image, at, covered ? vec4(frames, last.weight, off, 1.0) : vec4(0.0));
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    TAP_BEGIN(pixel, 0);
    reuse(pixel);
}
