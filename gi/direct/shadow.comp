#version 450
// Twin of shadow_kernel.h: shadow tests against a light's depth map. A point light takes six dispatches, a face each.
#extension GL_GOOGLE_include_directive : require
#include "core/detmath.glsl"
#include "raster/normal.glsl"
#include "raster/project.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform ShadowUniforms {
    Projection map;
    vec4 eye;
    vec4 forward;
    float footprint_scale;
    float footprint_base;
    float bias;
    float slope_bias;
    float max_slope;
    float perspective;
    int kernel;
    float samples;
    int published;
    int face;
    int width;
    int height;
    int soft;  // 0 none, 1 pcf, 2 esm
    float c;
    int test;  // 0 depth, 1 plane, 2 planes
    float least_sine;
    float rounding;
    int beside;
} u;
layout(binding = 1) uniform sampler2D position_image;  // xyz world, m
layout(binding = 2) uniform sampler2D normal_image;    // xyz unit
layout(binding = 3) uniform sampler2D map_position;    // xyz world, w: linear depth, m; 0 where nothing is
layout(binding = 4, r32f) uniform writeonly image2D visibility_image;
layout(binding = 5) uniform sampler2D map_normal;      // xyz unit, to the light; test = planes

// True where this map serves x: the points of one face have no other map.
bool serves(vec3 x) {
    precise vec3 from_eye = x - u.eye.xyz;
    return face_of(from_eye) == u.face;
}

struct Receiver {
    vec3 from_eye;
    float d_p;
    float bias;
    vec3 x;
    vec3 n;       // turned to the light
    ivec2 pixel;
    vec3 surface; // of the pixels around x, turned to the light; made where it is asked for
    bool asked;
    float least;
    float reach;
};

// How deep x lies, and how much depth changes across a texel there.
Receiver receiver(ivec2 pixel, vec3 x, vec3 n) {
    vec3 axis = u.forward.xyz;
    precise vec3 from_eye = x - u.eye.xyz;
    precise float d_p = from_eye.x * axis.x + from_eye.y * axis.y + from_eye.z * axis.z;
    TAP(d_p, d_p);
    precise float n_a = n.x * axis.x + n.y * axis.y + n.z * axis.z;
    precise float n_ray = n.x * from_eye.x + n.y * from_eye.y + n.z * from_eye.z;
    precise float n_r = u.perspective > 0.0 ? n_ray / max(d_p, u.map.least_w) : n_a;
    precise float across = sqrt(max(0.0, 1.0 - n_a * n_a));
    precise float slope = min(across / max(abs(n_r), 1e-6), u.max_slope);
    precise float footprint = u.footprint_scale * d_p + u.footprint_base;
    precise float bias = u.bias + u.slope_bias * footprint * slope;      TAP(bias, bias);
    float turned = n_r > 0.0 ? -1.0 : 1.0;                      TAP(turned, turned);
    precise float moved = abs(n.x * x.x) + abs(n.y * x.y) + abs(n.z * x.z);
    precise float least = u.bias + u.rounding * moved;          TAP(least, least);
    precise float reach = u.slope_bias * footprint * min(1.0 / max(abs(n_r), 1e-6), u.max_slope);
    TAP(reach, reach);
    precise vec3 facing = n * turned;
    return Receiver(from_eye, d_p, bias, x, facing, pixel, n, false, least, reach);
}

// What one axis of the picture tells of the surface of x: the step to the next pixel where that and the one behind it go on as
// the surface does.
struct Step {
    vec3 along;
    bool known;
};
Step goes_on(vec3 x, ivec2 pixel, ivec2 way) {
    ivec2 last = ivec2(u.width - 1, u.height - 1);
    vec3 a = texelFetch(position_image, clamp(pixel + way, ivec2(0), last), 0).xyz;
    vec3 b = texelFetch(position_image, clamp(pixel + 2 * way, ivec2(0), last), 0).xyz;
    precise vec3 along = a - x;
    precise vec3 bend = (b - a) - along;
    precise float limit = 0.25 * dot3(along, along);
    return Step(along, dot3(bend, bend) < limit);
}
Step step_along(vec3 x, ivec2 pixel, ivec2 way) {
    Step first = goes_on(x, pixel, way), other = goes_on(x, pixel, -way);
    return Step(first.known ? first.along : other.along, first.known || other.known);
}

// The normal of the surface that x lies on, turned to the light, from the pixels around; else n.
vec3 surface_normal(Receiver r) {
    Step row = step_along(r.x, r.pixel, ivec2(1, 0));
    Step column = step_along(r.x, r.pixel, ivec2(0, 1));
    vec3 plane = normalised(face_normal(row.along, column.along));
    precise vec3 surface = row.known && column.known ? plane : r.n;
    vec3 axis = u.forward.xyz;
    float along_ray = u.perspective > 0.0 ? dot3(surface, r.from_eye) : dot3(surface, axis);
    surface = surface * (along_ray > 0.0 ? -1.0 : 1.0);         TAP(surface, surface);
    return surface;
}

struct MapTexel {
    bool inside;
    ivec2 index;
    vec3 m;
    float depth;
};

MapTexel texel_at(ivec2 texel) {
    // Beyond the border lies another face; the border's texels stand in for it.
    if (u.face >= 0) texel = clamp(texel, ivec2(0), ivec2(u.map.size - 1));
    TAP(texel, texel);
    bool inside = texel.x >= 0 && texel.x < u.map.size && texel.y >= 0 && texel.y < u.map.size;
    TAP(inside, inside);
    ivec2 index = inside ? texel : ivec2(0);
    vec4 stored = texelFetch(map_position, index, 0);
    TAP(d_map, stored.w);
    return MapTexel(inside, index, stored.xyz, stored.w);
}

// Whether what the map holds there hides x from the light.
bool shadows(inout Receiver r, MapTexel t) {
    bool known = t.inside && t.depth > 0.0;
    if (u.test == 0) {
        precise float limit = t.depth + r.bias;
        return known && r.d_p > limit;
    }
    precise vec3 v = t.m - r.x;
    precise float height = r.n.x * v.x + r.n.y * v.y + r.n.z * v.z;      TAP(height, height);
    precise float d2 = v.x * v.x + v.y * v.y + v.z * v.z;
    precise float away = sqrt(d2);
    precise float on_it = r.least + (away <= r.reach ? u.least_sine : u.rounding) * away;
    TAP(on_it, on_it);
    bool above = known && height > on_it;
    // Most texels lie on the plane of x.
    if (!above) return false;
    if (u.beside != 0) {
        if (!r.asked) {
            r.surface = surface_normal(r);
            r.asked = true;
        }
        precise float over = r.surface.x * v.x + r.surface.y * v.y + r.surface.z * v.z;
        TAP(over, over);
        above = over > on_it;
    }
    if (u.test == 1) return above;
    vec3 n_m = texelFetch(map_normal, t.index, 0).xyz;
    precise float below = n_m.x * v.x + n_m.y * v.y + n_m.z * v.z;       TAP(below, below);
    return above && below > r.least;
}

// The hard test, and the shadow density.
float share_lit(vec3 x, Receiver r) {
    ivec2 centre = project(u.map, x);                           TAP(centre, centre);
    float count = 0.0;
    int first = -(u.kernel / 2);
    for (int k = 0; k < u.kernel * u.kernel; ++k) {
        TAP_SAMPLE(k);
        // VRSM Algorithm 4: centre + (i, j), from -kernel/2.
        MapTexel t = texel_at(centre + ivec2(first + k % u.kernel, first + k / u.kernel));
        if (u.published != 0) {
            precise float z_map = -t.depth - u.bias;
            bool counted = t.inside && z_map >= -r.d_p;
            count += counted ? 1.0 : 0.0;                       TAP(count, count);
        } else {
            count += shadows(r, t) ? 0.0 : 1.0;                 TAP(count, count);
        }
    }
    TAP_SAMPLE(-1);
    precise float visibility = count / u.samples;               TAP(visibility, visibility);
    return visibility;
}

// Where x falls on the map, in texels whose centres are whole numbers. As printed, corners are, and nothing is divided
// by w: 1/2 + clip / 2, times the size.
vec2 place_of(vec3 x) {
    if (u.published == 0) {
        vec2 corner = projected(u.map, x);
        precise vec2 place = corner - vec2(0.5);                TAP(place, place);
        return place;
    }
    Projection m = u.map;
    precise float row_x = m.to_texel_x.x * x.x + m.to_texel_x.y * x.y + m.to_texel_x.z * x.z + m.to_texel_x.w;
    precise float row_y = m.to_texel_y.x * x.x + m.to_texel_y.y * x.y + m.to_texel_y.z * x.z + m.to_texel_y.w;
    precise float row_w = m.to_texel_w.x * x.x + m.to_texel_w.y * x.y + m.to_texel_w.z * x.z + m.to_texel_w.w;
    precise float undivided = (1.0 - row_w) * (0.5 * float(m.size));
    precise vec2 offset = vec2(row_x + undivided, row_y + undivided);
    vec2 place = vec2(min(max(offset.x, m.low), m.high), min(max(offset.y, m.low), m.high));
    TAP(place, place);
    return place;
}

// What Listing 8 multiplies the difference of depths by.
float printed_cosine(vec3 n, Receiver r) {
    vec3 axis = u.forward.xyz;
    vec3 v = r.from_eye;
    precise float d2 = v.x * v.x + v.y * v.y + v.z * v.z;
    precise float inverse = 1.0 / sqrt(max(d2, 1e-37));
    precise float n_ray = n.x * v.x + n.y * v.y + n.z * v.z;
    precise float n_a = n.x * axis.x + n.y * axis.y + n.z * axis.z;
    precise float towards = u.perspective > 0.0 ? n_ray * inverse : n_a;
    float cosine = min(max(-towards, 0.0), 1.0);                TAP(cosine, cosine);
    return cosine;
}

// PCF and ESM: the (k + 1)^2 texels that a square of k x k texels around the projection touches, weighed by the share of
// each that it covers. Of k = 1: four, bilinearly.
float soft_shadow(vec3 x, vec3 n, Receiver r) {
    int k = u.kernel;
    int before = k / 2;
    vec2 centre = place_of(x);
    // An even square begins half a texel beside one whose middle is a texel's centre.
    precise vec2 place = centre + vec2(k % 2 == 0 ? 0.5 : 0.0);
    CHOICE(int(floor(place.x)));
    CHOICE(int(floor(place.y)));
    ivec2 first = ivec2(floor(place));
    precise vec2 fraction = place - vec2(first);                TAP(fraction, fraction);
    float factor = u.published != 0 ? printed_cosine(n, r) : 1.0;
    if (u.published != 0) r.bias = u.soft == 1 ? u.bias : 0.0;

    precise float sum = 0.0;
    float upper = 0.0;
    for (int j = 0; j <= k; ++j) {
        precise float row = 0.0;
        float left = 0.0;
        for (int i = 0; i <= k; ++i) {
            TAP_SAMPLE(j * (k + 1) + i);
            MapTexel t = texel_at(first + ivec2(i - before, j - before));
            float lit;
            if (u.soft == 1) {
                lit = shadows(r, t) ? 0.0 : 1.0;
            } else {
                precise float behind = max(0.0, (r.d_p - t.depth) - r.bias) * factor;
                TAP(behind, behind);
                precise float exponent = -(u.c * behind);
                lit = t.inside && t.depth > 0.0 ? det_exp(exponent) : 1.0;
            }
            TAP(lit, lit);
            // The first of a row counts by 1 - fraction, the last by fraction.
            if (i == 0) left = lit;
            row = i < k ? row + lit : row + fraction.x * (lit - left);
        }
        if (j == 0) upper = row;
        sum = j < k ? sum + row : sum + fraction.y * (row - upper);
    }
    TAP_SAMPLE(-1);
    precise float visibility = sum / u.samples;
    TAP(visibility, visibility);
    return visibility;
}

float shadow(ivec2 pixel) {
    vec3 x = texelFetch(position_image, pixel, 0).xyz;          TAP(x, x);
    vec3 n = texelFetch(normal_image, pixel, 0).xyz;            TAP(n, n);
    Receiver r = receiver(pixel, x, n);
    if (u.soft == 0) return share_lit(x, r);
    return soft_shadow(x, n, r);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    TAP_BEGIN(pixel, 0);
    if (u.face >= 0 && !serves(texelFetch(position_image, pixel, 0).xyz)) return;
    imageStore(visibility_image, pixel, vec4(shadow(pixel), 0.0, 0.0, 0.0));
}
