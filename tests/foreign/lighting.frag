#version 450
// Renderer B, first pass: direct light of a spot with a filtered shadow map.
layout(location = 0) out vec4 out_irradiance;
layout(location = 1) out float out_lit;

layout(std140, binding = 0) uniform Spot {
    mat4 world_to_map;  // clip space, y down, 0 <= z <= w
    vec3 position;      // m
    float cos_outer;
    vec3 axis;
    float cos_inner;
    vec3 colour;        // W/sr
    float bias;         // m
    vec2 planes;        // near and far, m
} spot;
layout(binding = 1) uniform sampler2D g_position;  // world, m
layout(binding = 2) uniform sampler2D g_normal;    // octahedral
layout(binding = 3) uniform sampler2D shadow_map;  // depth as it is drawn, 0 to 1

vec3 decode_normal(vec2 e) {
    vec3 v = vec3(e, 1.0 - abs(e.x) - abs(e.y));
    float t = max(-v.z, 0.0);
    v.x += v.x >= 0.0 ? -t : t;
    v.y += v.y >= 0.0 ? -t : t;
    return normalize(v);
}

float metres(float depth) {
    float n = spot.planes.x, f = spot.planes.y;
    return n * f / (f - depth * (f - n));
}

// The share of 3 x 3 texels that do not hide the point.
float lit_share(vec3 at) {
    vec4 clip = spot.world_to_map * vec4(at, 1.0);
    if (clip.w <= 0.0) return 1.0;
    ivec2 size = textureSize(shadow_map, 0);
    ivec2 middle = ivec2(floor((clip.xy / clip.w * 0.5 + 0.5) * vec2(size)));
    float depth = dot(at - spot.position, spot.axis);
    float open = 0.0;
    for (int y = -1; y <= 1; ++y) {
        for (int x = -1; x <= 1; ++x) {
            ivec2 texel = middle + ivec2(x, y);
            bool outside = any(lessThan(texel, ivec2(0))) || any(greaterThanEqual(texel, size));
            float stored = metres(texelFetch(shadow_map, texel, 0).r);
            open += outside || depth <= stored + spot.bias ? 1.0 : 0.0;
        }
    }
    return open / 9.0;
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 surface = texelFetch(g_position, pixel, 0);
    out_lit = 0.0;
    out_irradiance = vec4(0.0);
    if (surface.w == 0.0) return;
    out_lit = lit_share(surface.xyz);

    vec3 normal = decode_normal(texelFetch(g_normal, pixel, 0).xy);
    vec3 to_light = spot.position - surface.xyz;
    float distance_to_light = length(to_light);
    vec3 direction = to_light / distance_to_light;
    float cone = smoothstep(spot.cos_outer, spot.cos_inner, -dot(direction, spot.axis));
    float facing = max(dot(normal, direction), 0.0);
    out_irradiance.rgb = spot.colour * (out_lit * cone * facing / (distance_to_light * distance_to_light));
}
