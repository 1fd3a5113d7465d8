#version 450
// The peer's fragment stage: a G-buffer with the device's own texture filter. Specialised for untextured and for
// alpha-tested materials, so that no pixel pays for what its material does not have.

layout(constant_id = 0) const bool textured = false;
layout(constant_id = 1) const bool masked = false;

layout(push_constant) uniform Push {
    mat4 world_to_clip;
    vec4 reflectance;  // w: alpha
    float alpha_cutoff;
} push;
layout(binding = 0) uniform sampler2D base;

layout(location = 0) in vec4 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 uv;

layout(location = 0) out vec4 out_position;  // w: linear eye depth, m
layout(location = 1) out vec4 out_normal;    // w: 1
layout(location = 2) out vec4 out_albedo;

void main() {
    vec4 colour = push.reflectance;
    if (textured) colour *= textureLod(base, uv, 0.0);
    if (masked && colour.a < push.alpha_cutoff) discard;
    out_position = position;
    out_normal = vec4(normalize(gl_FrontFacing ? normal : -normal), 1.0);
    out_albedo = vec4(colour.rgb, 0.0);
}
