#version 450
// Twin of shadow_kernel.h: shadow tests against a light's depth map. A point light takes six dispatches, a face each.
#extension GL_GOOGLE_include_directive : require
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

float shadow(ivec2 pixel) {
    vec3 x = texelFetch(position_image, pixel, 0).xyz;          TAP(x, x);
    vec3 n = texelFetch(normal_image, pixel, 0).xyz;            TAP(n, n);
    ivec2 centre = project(u.map, x);                           TAP(centre, centre);

    // Measure the depth of x, and how much depth changes across a texel there.
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

    float count = 0.0;
    int first = -(u.kernel / 2);
    for (int k = 0; k < u.kernel * u.kernel; ++k) {
        TAP_SAMPLE(k);
        ivec2 texel = centre + ivec2(first + k % u.kernel, first + k / u.kernel);
        // Beyond the border lies another face; the border's texels stand in for it.
        if (u.face >= 0) texel = clamp(texel, ivec2(0), ivec2(u.map.size - 1));
        TAP(texel, texel);
        bool inside = texel.x >= 0 && texel.x < u.map.size && texel.y >= 0 && texel.y < u.map.size;
        TAP(inside, inside);
        float d_map = texelFetch(map_position, inside ? texel : ivec2(0), 0).w;
        TAP(d_map, d_map);
        if (u.published != 0) {
            precise float z_map = -d_map - u.bias;
            bool counted = inside && z_map >= -d_p;
            count += counted ? 1.0 : 0.0;                       TAP(count, count);
        } else {
            precise float limit = d_map + bias;
            bool shadowed = inside && d_map > 0.0 && d_p > limit;
            count += shadowed ? 0.0 : 1.0;                      TAP(count, count);
        }
    }
    TAP_SAMPLE(-1);
    precise float visibility = count / u.samples;             TAP(visibility, visibility);
    return visibility;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    TAP_BEGIN(pixel, 0);
    if (u.face >= 0 && !serves(texelFetch(position_image, pixel, 0).xyz)) return;
    imageStore(visibility_image, pixel, vec4(shadow(pixel), 0.0, 0.0, 0.0));
}
