#version 450
// Renderer A: one bounce of light and a light's shadow, in one compute pass. All is in view space, maps are half floats.
layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform Frame {
    mat4 view_to_light;   // clip space of the light's map, y down, 0 <= z <= w
    vec4 light_position;  // view space, m
    vec4 light_axis;      // view space, unit
    ivec2 resolution;
    int taps;
    float shadow_bias;    // m
} frame;

layout(binding = 1) uniform sampler2D g_position;  // m
layout(binding = 2) uniform sampler2D g_normal;
layout(binding = 3) uniform sampler2D l_position;  // m; w: distance along the light's axis, 0 where nothing is
layout(binding = 4) uniform sampler2D l_normal;
layout(binding = 5) uniform sampler2D l_flux;      // W
layout(std430, binding = 6) readonly buffer Taps { vec4 taps[]; };  // xy: texels; z: texels that it stands for
layout(binding = 7, rgba16f) uniform writeonly image2D o_bounce;
layout(binding = 8, r32f) uniform writeonly image2D o_lit;

const float INV_PI = 0.318309886;
const float NEAREST2 = 1.0e-4;  // m2

bool in_map(ivec2 t) {
    ivec2 size = textureSize(l_position, 0);
    return all(greaterThanEqual(t, ivec2(0))) && all(lessThan(t, size));
}

// Irradiance at P by the small light that a texel of the map is.
vec3 from_texel(ivec2 t, vec3 P, vec3 N) {
    vec3 r = P - texelFetch(l_position, t, 0).xyz;
    float rr = max(dot(r, r), NEAREST2);
    float leaving = max(dot(texelFetch(l_normal, t, 0).xyz, r), 0.0);
    float arriving = max(-dot(N, r), 0.0);
    return texelFetch(l_flux, t, 0).rgb * (leaving * arriving / (rr * rr));
}

vec3 bounce(vec2 centre, vec3 P, vec3 N) {
    vec3 total = vec3(0.0);
    for (int i = 0; i < frame.taps; i++) {
        vec4 tap = taps[i];
        ivec2 t = ivec2(floor(centre + tap.xy));
        if (!in_map(t)) continue;
        total += from_texel(t, P, N) * tap.z;
    }
    return total * INV_PI;
}

float lit(vec2 centre, vec3 P) {
    ivec2 t = ivec2(floor(centre));
    if (!in_map(t)) return 1.0;
    float nearest = texelFetch(l_position, t, 0).w;
    if (nearest <= 0.0) return 1.0;
    float depth = dot(P - frame.light_position.xyz, frame.light_axis.xyz);
    return depth > nearest + frame.shadow_bias ? 0.0 : 1.0;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, frame.resolution))) return;

    vec3 P = texelFetch(g_position, pixel, 0).xyz;
    vec3 N = texelFetch(g_normal, pixel, 0).xyz;
    vec4 clip = frame.view_to_light * vec4(P, 1.0);

    vec3 indirect = vec3(0.0);
    float direct = 1.0;
    if (clip.w > 0.0) {
        vec2 uv = clip.xy / clip.w * 0.5 + 0.5;
        vec2 centre = uv * vec2(textureSize(l_position, 0));
        indirect = bounce(centre, P, N);
        direct = lit(centre, P);
    }
    imageStore(o_bounce, pixel, vec4(indirect, 1.0));
    imageStore(o_lit, pixel, vec4(direct));
}
