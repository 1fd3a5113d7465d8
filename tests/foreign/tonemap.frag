#version 450
// Renderer B, last pass: Reinhard's curve, and the display's.
layout(location = 0) out vec4 out_display;

layout(std140, binding = 0) uniform Display {
    float exposure;
} display;
layout(binding = 1) uniform sampler2D radiance;  // W/(m2 sr)

float srgb(float c) {
    return c <= 0.0031308 ? 12.92 * c : 1.055 * pow(c, 1.0 / 2.4) - 0.055;
}

void main() {
    vec3 x = max(texelFetch(radiance, ivec2(gl_FragCoord.xy), 0).rgb, 0.0) * display.exposure;
    x = x / (1.0 + x);
    out_display = vec4(srgb(x.r), srgb(x.g), srgb(x.b), 1.0);
}
