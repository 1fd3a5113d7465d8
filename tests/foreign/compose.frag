#version 450
// Renderer B, third pass: light from everywhere, darkened, and what leaves the surfaces.
layout(location = 0) out vec4 out_radiance;
layout(location = 1) out vec4 out_soft;

layout(std140, binding = 0) uniform Look {
    vec4 ambient;  // W/m2
    vec4 sky;      // W/(m2 sr)
} look;
layout(binding = 1) uniform sampler2D g_albedo;    // a: 1 on a surface
layout(binding = 2) uniform sampler2D g_emission;  // W/m2
layout(binding = 3) uniform sampler2D direct;      // W/m2
layout(binding = 4) uniform sampler2D bounced;     // W/m2
layout(binding = 5) uniform sampler2D openness;

const float PI = 3.14159265;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 albedo = texelFetch(g_albedo, pixel, 0);
    vec3 emitted = texelFetch(g_emission, pixel, 0).rgb;
    float open = texelFetch(openness, pixel, 0).r;

    vec3 soft = albedo.a > 0.5 ? (texelFetch(bounced, pixel, 0).rgb + look.ambient.rgb) * open : vec3(0.0);
    vec3 received = texelFetch(direct, pixel, 0).rgb + soft;
    vec3 radiance = (albedo.rgb * received + emitted) / PI;
    out_soft = vec4(soft, 1.0);
    out_radiance = vec4(albedo.a > 0.5 ? radiance : look.sky.rgb, 1.0);
}
