#version 450
// Twin of indirect_shadow_kernel.h: indirect shadows of dynamic meshes, as spheres.
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform IndirectShadowUniforms {
    int width;
    int height;
    int spheres;
    int directional;  // 0: light comes from everywhere alike
} u;
layout(binding = 1) uniform sampler2D position_image;                    // xyz world, m
layout(binding = 2) uniform sampler2D normal_image;                      // xyz unit; w 1: a point
layout(binding = 3) uniform sampler2D irradiance_image;                  // W/m2
layout(std430, binding = 4) readonly buffer Id { ivec2 id[]; };          // object, triangle
layout(std430, binding = 5) readonly buffer Owner { ivec2 owner[]; };    // first and last object that a sphere stands for
layout(std430, binding = 6) readonly buffer Spheres { vec4 spheres[]; }; // seven a sphere: centre and radius; b, a; b', a'
layout(binding = 7, rgba32f) uniform writeonly image2D shaded_image;

const int shadow_rows = 7;

// atan2(y, x), y >= 0: acos by Abramowitz and Stegun 4.4.46, to 2e-8, whose sqrt(1 - c) is taken as s / sqrt(1 + c).
float angle_of(float x, float y) {
    precise float len = max(sqrt(x * x + y * y), 1e-18);
    precise float c = min(abs(x) / len, 1.0);
    precise float s = y / len;
    precise float p = -0.0012624911 * c + 0.0066700901;
    p = p * c + -0.0170881256;
    p = p * c + 0.0308918810;
    p = p * c + -0.0501743046;
    p = p * c + 0.0889789874;
    p = p * c + -0.2145988016;
    p = p * c + 1.5707963050;
    precise float angle = s / sqrt(1.0 + c) * p;
    precise float other = 3.14159265 - angle;
    return x < 0.0 ? other : angle;
}

struct HiddenShare {
    float share;
    float cosine;
    vec3 w;
};
HiddenShare hidden_share(vec3 x, vec3 n, vec4 sphere) {
    precise vec3 to = sphere.xyz - x;
    precise float r2 = sphere.w * sphere.w;
    precise float d2 = max(max(to.x * to.x + to.y * to.y + to.z * to.z, r2), 1e-30);
    precise float d = sqrt(d2);                                   TAP(d, d);
    precise vec3 w = vec3(to.x / d, to.y / d, to.z / d);
    precise float q = r2 / d2;                                    TAP(q, q);
    precise float cosine = n.x * w.x + n.y * w.y + n.z * w.z;     TAP(cos_omega, cosine);
    precise float open = sqrt(max(1.0 - q, 0.0));                 TAP(C, open);
    precise float whole = q * cosine;
    precise float s2 = q - cosine * cosine;
    bool cut = s2 > 0.0;                                          TAP(cut, cut);
    precise float share = whole;
    if (cut) {
        precise float s = sqrt(s2);                               TAP(s, s);
        precise float below = -(open * cosine);
        float psi = angle_of(open, s);
        float phi = angle_of(below, s);
        TAP(psi, psi);
        TAP(phi, phi);
        share = (psi - open * s + whole * phi) * 0.318309886;
    }
    return HiddenShare(min(max(share, 0.0), 1.0), open, w);
}

// max(0, a + m b . w), the row b, a.
float radiance_along(int row, vec3 w, float m) {
    vec4 l = spheres[row];
    precise float sum = l.w + m * (l.x * w.x + l.y * w.y + l.z * w.z);
    return max(sum, 0.0);
}

vec4 indirect_shadow(ivec2 at) {
    int pixel = at.y * u.width + at.x;
    vec4 normal = texelFetch(normal_image, at, 0);
    vec3 n = normal.xyz;                                          TAP(n, n);
    bool point = normal.w > 0.0;
    vec4 lit = texelFetch(irradiance_image, at, 0);
    vec3 e = lit.xyz;                                             TAP(E, e);
    vec3 x = texelFetch(position_image, at, 0).xyz;               TAP(x, x);
    int object = id[pixel].x;                                     TAP(object, object);
    precise float hidden = 0.0;
    precise float total = 0.0;
    precise vec3 sum = vec3(0.0);
    for (int i = 0; i < u.spheres; ++i) {
        TAP_SAMPLE(i);
        int first = i * shadow_rows;
        HiddenShare h = hidden_share(x, n, spheres[first]);
        bool own = object >= owner[i].x && object <= owner[i].y;  TAP(own, own);
        float share = point && !own ? h.share : 0.0;
        TAP(F, share);
        if (!(share > 0.0)) continue;
        hidden = hidden + share * (1.0 - hidden);
        if (u.directional == 0) continue;
        total = total + share;
        precise float m = 0.666666667 * (1.0 + h.cosine + h.cosine * h.cosine) / (1.0 + h.cosine);
        TAP(m, m);
        precise vec3 l = vec3(radiance_along(first + 1, h.w, m) - radiance_along(first + 4, h.w, m),
                              radiance_along(first + 2, h.w, m) - radiance_along(first + 5, h.w, m),
                              radiance_along(first + 3, h.w, m) - radiance_along(first + 6, h.w, m));
        TAP(L, l);
        sum = sum + share * l;
    }
    TAP_SAMPLE(-1);
    TAP(S, hidden);
    precise vec3 left = e - e * hidden;
    if (u.directional != 0) {
        precise float scale = 3.14159265 * hidden / (total > 0.0 ? total : 1.0);
        TAP(scale, scale);
        left = e - scale * sum;
        left = max(left, vec3(0.0));
    }
    vec3 shaded = hidden > 0.0 ? left : e;                        TAP(shaded, shaded);
    return vec4(shaded, lit.w);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    TAP_BEGIN(pixel, 0);
    imageStore(shaded_image, pixel, indirect_shadow(pixel));
}
