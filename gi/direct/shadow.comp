#version 450
// Twin of shadow_kernel.h: hard shadow test against a light's depth map.
layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform ShadowUniforms {
    vec4 to_texel_x;
    vec4 to_texel_y;
    vec4 to_texel_w;
    vec4 eye;
    vec4 forward;
    float least_w;
    float footprint_scale;
    float footprint_base;
    float bias;
    float slope_bias;
    float max_slope;
    float perspective;
    int size;
    int width;
    int height;
} u;
layout(binding = 1) uniform sampler2D position_image;  // xyz world, m
layout(binding = 2) uniform sampler2D normal_image;    // xyz unit
layout(binding = 3) uniform sampler2D map_position;    // w: linear depth, m; 0 where nothing is
layout(binding = 4, r32f) uniform writeonly image2D visibility_image;

float shadow(ivec2 pixel) {
    vec3 x = texelFetch(position_image, pixel, 0).xyz;
    vec3 n = texelFetch(normal_image, pixel, 0).xyz;

    // Project x to the map.
    precise float row_x = u.to_texel_x.x * x.x + u.to_texel_x.y * x.y + u.to_texel_x.z * x.z + u.to_texel_x.w;
    precise float row_y = u.to_texel_y.x * x.x + u.to_texel_y.y * x.y + u.to_texel_y.z * x.z + u.to_texel_y.w;
    precise float row_w = u.to_texel_w.x * x.x + u.to_texel_w.y * x.y + u.to_texel_w.z * x.z + u.to_texel_w.w;
    precise float w = max(u.least_w, row_w);
    const float far = 1048576.0;
    precise vec2 projection = vec2(min(max(row_x / w, -far), far), min(max(row_y / w, -far), far));
    ivec2 texel = ivec2(floor(projection));
    bool inside = texel.x >= 0 && texel.x < u.size && texel.y >= 0 && texel.y < u.size;

    // Measure the depth of x, and how much depth changes across a texel there.
    vec3 axis = u.forward.xyz;
    precise vec3 from_eye = x - u.eye.xyz;
    precise float d_p = from_eye.x * axis.x + from_eye.y * axis.y + from_eye.z * axis.z;
    precise float n_a = n.x * axis.x + n.y * axis.y + n.z * axis.z;
    precise float n_ray = n.x * from_eye.x + n.y * from_eye.y + n.z * from_eye.z;
    precise float n_r = u.perspective > 0.0 ? n_ray / max(d_p, u.least_w) : n_a;
    precise float across = sqrt(max(0.0, 1.0 - n_a * n_a));
    precise float slope = min(across / max(abs(n_r), 1e-6), u.max_slope);
    precise float footprint = u.footprint_scale * d_p + u.footprint_base;
    precise float bias = u.bias + u.slope_bias * footprint * slope;

    float d_map = texelFetch(map_position, inside ? texel : ivec2(0), 0).w;
    precise float limit = d_map + bias;
    bool shadowed = inside && d_map > 0.0 && d_p > limit;
    return shadowed ? 0.0 : 1.0;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    imageStore(visibility_image, pixel, vec4(shadow(pixel), 0.0, 0.0, 0.0));
}
