#version 450
// Renderer B, second pass: how open each point is, by depths in a half ball about it.
layout(location = 0) out float out_open;

layout(std140, binding = 0) uniform Camera {
    mat4 world_to_clip;  // y down, 0 <= z <= w
    vec4 eye;
    vec4 forward;
    float radius;        // m
    float bias;          // m
    int count;
} camera;
layout(binding = 1) uniform sampler2D g_position;  // world, m; w: depth, 0 where nothing is
layout(binding = 2) uniform sampler2D g_normal;    // octahedral
layout(binding = 3) uniform sampler2D turns;       // 4 x 4: cosine and sine
layout(std430, binding = 4) readonly buffer Kernel { vec4 points[]; };

vec3 decode_normal(vec2 e) {
    vec3 v = vec3(e, 1.0 - abs(e.x) - abs(e.y));
    float t = max(-v.z, 0.0);
    v.x += v.x >= 0.0 ? -t : t;
    v.y += v.y >= 0.0 ? -t : t;
    return normalize(v);
}

// Columns: two tangents, turned by the pixel's angle, and the normal (Duff et al. 2017).
mat3 frame_about(vec3 n, vec2 turn) {
    float s = n.z < 0.0 ? -1.0 : 1.0;
    float a = -1.0 / (s + n.z);
    float b = n.x * n.y * a;
    vec3 u = vec3(1.0 + s * n.x * n.x * a, s * b, -s * n.x);
    vec3 v = vec3(b, s + n.y * n.y * a, -n.y);
    return mat3(u * turn.x + v * turn.y, v * turn.x - u * turn.y, n);
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    ivec2 size = textureSize(g_position, 0);
    vec4 centre = texelFetch(g_position, pixel, 0);
    out_open = 0.0;
    if (centre.w == 0.0) return;

    vec3 normal = decode_normal(texelFetch(g_normal, pixel, 0).xy);
    mat3 frame = frame_about(normal, texelFetch(turns, pixel & 3, 0).xy);
    float own_depth = dot(centre.xyz - camera.eye.xyz, camera.forward.xyz);

    float hidden = 0.0, seen = 0.0;
    for (int i = 0; i < camera.count; ++i) {
        vec3 at = centre.xyz + frame * (points[i].xyz * camera.radius);
        vec4 clip = camera.world_to_clip * vec4(at, 1.0);
        if (clip.w <= 0.0) continue;
        ivec2 texel = ivec2(floor((clip.xy / clip.w * 0.5 + 0.5) * vec2(size)));
        if (any(lessThan(texel, ivec2(0))) || any(greaterThanEqual(texel, size))) continue;
        seen += 1.0;

        vec4 met = texelFetch(g_position, texel, 0);
        float depth = dot(at - camera.eye.xyz, camera.forward.xyz);
        bool before = met.w > 0.0 && met.w < depth;
        bool above = dot(met.xyz - centre.xyz, normal) > camera.bias;
        if (before && above) hidden += smoothstep(0.0, 1.0, camera.radius / max(abs(own_depth - met.w), 1.0e-6));
    }
    out_open = 1.0 - hidden / max(seen, 1.0);
}
