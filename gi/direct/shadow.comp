#version 450
// Twin of shadow_kernel.h: shadow tests against a light's depth map. A point light takes six dispatches, a face each.
#extension GL_GOOGLE_include_directive : require
#include "core/detmath.glsl"
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
} u;
layout(binding = 1) uniform sampler2D position_image;  // xyz world, m
layout(binding = 2) uniform sampler2D normal_image;    // xyz unit
layout(binding = 3) uniform sampler2D map_position;    // w: linear depth, m; 0 where nothing is
layout(binding = 4, r32f) uniform writeonly image2D visibility_image;

// True where this map serves x: the points of one face have no other map.
bool serves(vec3 x) {
    precise vec3 from_eye = x - u.eye.xyz;
    return face_of(from_eye) == u.face;
}

struct Receiver {
    vec3 from_eye;
    float d_p;
    float bias;
};

// How deep x lies, and how much depth changes across a texel there.
Receiver receiver(vec3 x, vec3 n) {
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
    return Receiver(from_eye, d_p, bias);
}

struct MapTexel {
    bool inside;
    float depth;
};

MapTexel texel_at(ivec2 texel) {
    // Beyond the border lies another face; the border's texels stand in for it.
    if (u.face >= 0) texel = clamp(texel, ivec2(0), ivec2(u.map.size - 1));
    TAP(texel, texel);
    bool inside = texel.x >= 0 && texel.x < u.map.size && texel.y >= 0 && texel.y < u.map.size;
    TAP(inside, inside);
    float d_map = texelFetch(map_position, inside ? texel : ivec2(0), 0).w;
    TAP(d_map, d_map);
    return MapTexel(inside, d_map);
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
            precise float limit = t.depth + r.bias;
            bool shadowed = t.inside && t.depth > 0.0 && r.d_p > limit;
            count += shadowed ? 0.0 : 1.0;                      TAP(count, count);
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

// PCF and ESM: four texels, weighed bilinearly.
float soft_shadow(vec3 x, vec3 n, Receiver r) {
    vec2 place = place_of(x);
    CHOICE(int(floor(place.x)));
    CHOICE(int(floor(place.y)));
    ivec2 first = ivec2(floor(place));
    precise vec2 fraction = place - vec2(first);                TAP(fraction, fraction);
    float factor = u.published != 0 ? printed_cosine(n, r) : 1.0;
    float bias = u.published == 0 ? r.bias : (u.soft == 1 ? u.bias : 0.0);

    float lit[4];
    for (int k = 0; k < 4; ++k) {
        TAP_SAMPLE(k);
        MapTexel t = texel_at(first + ivec2(k % 2, k / 2));
        bool known = t.inside && t.depth > 0.0;
        if (u.soft == 1) {
            precise float limit = t.depth + bias;
            lit[k] = known && r.d_p > limit ? 0.0 : 1.0;
        } else {
            precise float behind = max(0.0, (r.d_p - t.depth) - bias) * factor;
            TAP(behind, behind);
            precise float exponent = -(u.c * behind);
            lit[k] = known ? det_exp(exponent) : 1.0;
        }
        TAP(lit, lit[k]);
    }
    TAP_SAMPLE(-1);
    precise float upper = lit[0] + fraction.x * (lit[1] - lit[0]);
    precise float lower = lit[2] + fraction.x * (lit[3] - lit[2]);
    precise float visibility = upper + fraction.y * (lower - upper);
    TAP(visibility, visibility);
    return visibility;
}

float shadow(ivec2 pixel) {
    vec3 x = texelFetch(position_image, pixel, 0).xyz;          TAP(x, x);
    vec3 n = texelFetch(normal_image, pixel, 0).xyz;            TAP(n, n);
    Receiver r = receiver(x, n);
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
