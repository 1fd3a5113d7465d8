#version 450 core
// Renderer C, second pass: direct light of a spot, its shadow compared by the sampler.
in vec2 v_uv;
layout(location = 0) out vec4 o_direct;
layout(location = 1) out float o_lit;

uniform sampler2D u_position;      // world, m
uniform sampler2D u_normal;        // 10 bits, biased; alpha 1 on a surface
uniform sampler2DShadow u_shadow;  // distance along the light's axis over u_range; 1 beyond the border
uniform mat4 u_light;              // clip space of the map, y up
uniform vec3 u_light_position;     // m
uniform vec3 u_light_axis;
uniform vec3 u_intensity;          // W/sr
uniform vec2 u_cone;               // cosines of the outer and the inner half angle
uniform float u_range;             // m
uniform float u_bias;              // m

void main() {
    vec3 p = texture(u_position, v_uv).xyz;
    vec4 packed_normal = texture(u_normal, v_uv);
    vec3 n = packed_normal.a > 0.5 ? normalize(packed_normal.xyz * 2.0 - 1.0) : vec3(0.0);

    vec4 s = u_light * vec4(p, 1.0);
    float lit = 1.0;
    if (s.w > 0.0) {
        float depth = dot(p - u_light_position, u_light_axis);
        lit = texture(u_shadow, vec3(s.xy / s.w * 0.5 + 0.5, (depth - u_bias) / u_range));
    }
    o_lit = lit;

    vec3 l = u_light_position - p;
    float r2 = dot(l, l);
    l *= inversesqrt(r2);
    float t = clamp((-dot(l, u_light_axis) - u_cone.x) / (u_cone.y - u_cone.x), 0.0, 1.0);
    float falloff = t * t * (3.0 - 2.0 * t);
    o_direct = vec4(u_intensity * (falloff * max(dot(n, l), 0.0) * lit / r2), 1.0);
}
