#version 450
// Twin of cells_kernel.h: reflections in what a view sees, from texel to texel.
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"
#include "gi/screen/mirrored_ray.glsl"
#include "gi/screen/seen_from.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform CellsUniforms {
    SeenFrom view;
    vec4 eye;
    float reach;
    float thickness;
    float bias;
    int cells;
    int levels;
    int number;
    int padded;
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
layout(binding = 6) uniform sampler2D nearest_image;   // of the view: x least depth of blocks, m
layout(binding = 7) uniform sampler2D before_image;    // what earlier views found
layout(binding = 8) uniform sampler2D rays_image;      // as screen.lobe writes them
layout(binding = 9, rgba32f) uniform writeonly image2D hit_image;

struct Track {
    float x_0;
    float x_1;
    float y_0;
    float y_1;
    float c_0;
    float c_1;
    float d_0;
    float d_1;
    float first;
    float last;
};

// Keeps of first..last where a + t b >= 0.
void clip(float a, float b, inout float first, inout float last) {
    bool along = b == 0.0;
    precise float t = -a / (along ? 1.0 : b);
    first = b > 0.0 ? max(first, t) : first;
    last = b < 0.0 ? min(last, t) : last;
    last = along && a < 0.0 ? -1.0 : last;
}

Track track_of(MirroredRay ray) {
    vec3 o = ray.from_anchor;
    vec3 r = ray.r;
    vec4 to_x = u.view.to_x;
    vec4 to_y = u.view.to_y;
    vec4 axis = u.view.forward;
    precise float x_0 = to_x.x * o.x + to_x.y * o.y + to_x.z * o.z + to_x.w;
    precise float x_1 = to_x.x * r.x + to_x.y * r.y + to_x.z * r.z;
    precise float y_0 = to_y.x * o.x + to_y.y * o.y + to_y.z * o.z + to_y.w;
    precise float y_1 = to_y.x * r.x + to_y.y * r.y + to_y.z * r.z;
    precise float d_0 = axis.x * o.x + axis.y * o.y + axis.z * o.z + axis.w;
    precise float d_1 = axis.x * r.x + axis.y * r.y + axis.z * r.z;
    bool perspective = u.view.perspective > 0.0;
    float c_0 = perspective ? d_0 : 1.0;
    float c_1 = perspective ? d_1 : 0.0;
    float first = 0.0;
    float last = u.reach;
    precise float before_eye = d_0 - u.view.least_depth;
    if (perspective) clip(before_eye, d_1, first, last);
    clip(x_0, x_1, first, last);
    precise float right_0 = float(u.view.width) * c_0 - x_0;
    precise float right_1 = float(u.view.width) * c_1 - x_1;
    clip(right_0, right_1, first, last);
    clip(y_0, y_1, first, last);
    precise float below_0 = float(u.view.height) * c_0 - y_0;
    precise float below_1 = float(u.view.height) * c_1 - y_1;
    clip(below_0, below_1, first, last);
    TAP(within, vec2(first, last));
    return Track(x_0, x_1, y_0, y_1, c_0, c_1, d_0, d_1, first, last);
}

struct Border {
    float t;
    bool up;
};

// Where a coordinate (a + t b) / (c_0 + t c_1) leaves [low, high), by which border.
Border border_of(Track k, float a, float b, int low, int high) {
    precise float turn = b * k.c_0 - a * k.c_1;
    bool up = turn > 0.0;
    float at = float(up ? high : low);
    precise float rate = b - at * k.c_1;
    bool leaves = (up ? rate : -rate) > 0.0;
    precise float t = (at * k.c_0 - a) / (leaves ? rate : 1.0);
    return Border(leaves ? t : 3e38, up);
}

// The texel of that coordinate at t, within [low, high).
int texel_at(Track k, float a, float b, float t, int low, int high) {
    precise float x = (a + t * b) / (k.c_0 + t * k.c_1);
    float held = min(max(x, -65536.0), 65536.0);
    CHOICE(int(floor(held)));
    return min(max(int(floor(held)), low), high - 1);
}

// The ray's depth at t.
float depth_at(Track k, float t) {
    precise float depth = k.d_0 + t * k.d_1;
    return depth;
}

// Where the ray is as deep.
float reached_at(Track k, float depth) {
    precise float t = (depth - k.d_0) / k.d_1;
    return t;
}

// How much deeper one is.
float deeper(float one, float other) {
    precise float by = one - other;
    return by;
}

Crossing walk(MirroredRay ray, Track k, bool looking) {
    Crossing c = Crossing(0.0, ivec2(0), 0.0, false);
    bool in_front = true;
    float t = k.first;
    int level = 0;
    int x = texel_at(k, k.x_0, k.x_1, t, 0, u.view.width);
    int y = texel_at(k, k.y_0, k.y_1, t, 0, u.view.height);
    for (int i = 0; looking && i < u.cells; ++i) {
        TAP_SAMPLE(i);
        ivec2 block = ivec2(x >> level, y >> level);
        ivec2 low = block << level;
        ivec2 high = (block + 1) << level;
        Border of_x = border_of(k, k.x_0, k.x_1, low.x, high.x);
        Border of_y = border_of(k, k.y_0, k.y_1, low.y, high.y);
        float leaves = max(t, min(k.last, min(of_x.t, of_y.t)));
        TAP(texel, ivec2(x, y));
        TAP(level, level);
        TAP(leaves, leaves);

        // What lies there, and where the ray is.
        bool single = level == 0;
        float least;
        if (single) {
            float depth = texelFetch(map_position, ivec2(x, y), 0).w;
            least = depth > 0.0 ? depth : 3e38;
        } else {
            int row = u.padded - (2 * u.padded >> level) + block.y;
            least = texelFetch(nearest_image, ivec2(block.x, row), 0).x;
        }
        float d_in = depth_at(k, t);
        float d_out = depth_at(k, leaves);
        TAP(least, least);
        TAP(depths, vec2(d_in, d_out));
        bool clear = max(d_in, d_out) < least;
        bool before = in_front || d_in < least;
        bool met = single && !clear && before && deeper(min(d_in, d_out), least) <= u.thickness;
        if (met) {
            vec3 q = texelFetch(map_position, ivec2(x, y), 0).xyz;
            vec3 n_q = texelFetch(map_normal, ivec2(x, y), 0).xyz;
            met = may_be_met(ray, q, n_q, u.bias);
            float reaches = d_in < least ? min(max(reached_at(k, least), t), leaves) : t;
            if (met) c = Crossing(reaches, ivec2(x, y), deeper(depth_at(k, reaches), least), true);
        }
        TAP(met, met);
        looking = !met;

        // Into a quarter of the block, or on into the next.
        bool on = single || clear;
        bool by_x = of_x.t <= of_y.t;
        looking = looking && (!on || leaves < k.last);
        int beside = texel_at(k, by_x ? k.y_0 : k.x_0, by_x ? k.y_1 : k.x_1, leaves, by_x ? low.y : low.x, by_x ? high.y : high.x);
        int next_x = by_x ? (of_x.up ? high.x : low.x - 1) : beside;
        int next_y = by_x ? beside : (of_y.up ? high.y : low.y - 1);
        x = on ? min(max(next_x, 0), u.view.width - 1) : x;
        y = on ? min(max(next_y, 0), u.view.height - 1) : y;
        in_front = on ? d_out < least : in_front;
        t = on ? leaves : t;
        level = on ? min(level + 1, u.levels) : level - 1;
    }
    TAP_SAMPLE(-1);
    return c;
}

vec4 cells(ivec2 item) {
    ivec2 pixel = u.rows > 0 ? ivec2(item.x % u.columns, item.y % u.rows) : item;
    vec3 p = texelFetch(position_image, pixel, 0).xyz;            TAP(p, p);
    vec3 n = texelFetch(normal_image, pixel, 0).xyz;              TAP(n, n);
    precise vec3 to_p = p - u.eye.xyz;
    MirroredRay ray = mirrored_ray(p, n, to_p, u.view.anchor.xyz);
    vec4 before = texelFetch(before_image, item, 0);
    bool starts = ray.cosine < 0.0 && texelFetch(mirror_image, pixel, 0).w > 0.0;
    if (u.rows > 0) starts = take_drawn(texelFetch(rays_image, item, 0), ray);
    Track track = track_of(ray);
    bool looking = starts && before.w != 1.0 && track.first <= track.last;
    return nearer_hit(before, walk(ray, track, looking), u.number);
}

void main() {
    ivec2 item = ivec2(gl_GlobalInvocationID.xy);
    if (item.x >= u.width || item.y >= u.height) return;
    TAP_BEGIN(item, 0);
    imageStore(hit_image, item, cells(item));
}
