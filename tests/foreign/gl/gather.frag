#version 450 core
// Renderer C, first pass: one bounce of light from a reflective shadow map, all by texture().
in vec2 v_uv;
layout(location = 0) out vec4 o_indirect;

uniform sampler2D u_position;      // world, m
uniform sampler2D u_normal;        // 10 bits, biased; alpha 1 on a surface
uniform sampler2D u_rsm_position;  // world, m
uniform sampler2D u_rsm_normal;
uniform sampler2D u_rsm_flux;      // W; black beyond the border
uniform mat4 u_light;              // clip space of the map, y up
uniform float u_map_size;          // texels
uniform int u_count;
uniform vec3 u_kernel[64];         // xy: whole texels; z: texels that it stands for

void main() {
    vec3 p = texture(u_position, v_uv).xyz;
    vec4 packed_normal = texture(u_normal, v_uv);
    vec3 n = packed_normal.a > 0.5 ? normalize(packed_normal.xyz * 2.0 - 1.0) : vec3(0.0);

    vec3 e = vec3(0.0);
    vec4 s = u_light * vec4(p, 1.0);
    if (s.w > 0.0) {
        vec2 middle = floor((s.xy / s.w * 0.5 + 0.5) * u_map_size) + 0.5;
        for (int i = 0; i < u_count; ++i) {
            vec2 st = (middle + u_kernel[i].xy) / u_map_size;
            vec3 d = texture(u_rsm_position, st).xyz - p;
            vec3 m = texture(u_rsm_normal, st).xyz;
            float d2 = max(dot(d, d), 1.0e-4);
            float g = max(0.0, dot(n, d)) * max(0.0, -dot(m, d)) / (d2 * d2);
            e += texture(u_rsm_flux, st).rgb * g * u_kernel[i].z;
        }
    }
    o_indirect = vec4(e / 3.14159265, 1.0);
}
