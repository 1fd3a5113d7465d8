#version 450
// The peer's vertex stage: transforms a vertex as any engine does.

layout(push_constant) uniform Push {
    mat4 world_to_clip;
    vec4 reflectance;  // w: alpha
    float alpha_cutoff;
} push;

layout(location = 0) in vec4 position_u;
layout(location = 1) in vec4 normal_v;

layout(location = 0) out vec4 position;  // world, m; w: linear eye depth
layout(location = 1) out vec3 normal;
layout(location = 2) out vec2 uv;

void main() {
    gl_Position = push.world_to_clip * vec4(position_u.xyz, 1.0);
    position = vec4(position_u.xyz, gl_Position.w);
    normal = normal_v.xyz;
    uv = vec2(position_u.w, normal_v.w);
}
