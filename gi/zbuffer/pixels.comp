#version 450
// Twin of pixels_kernel.h: light at pixels.
#extension GL_GOOGLE_include_directive : require
#include "core/detmath.glsl"
#include "core/tap.glsl"
#include "gi/zbuffer/shade_uniforms.glsl"
#include "raster/barycentric.glsl"
#include "raster/light.glsl"
#include "raster/arriving.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform PixelsUniforms {
    ShadeUniforms shade;
    int width;
    int height;
    int triangles;  // that id counts
    int vertices;
    int normal;     // 0: the G-buffer's, 1: interpolated and made unit, 2: as it is interpolated
    int emits;      // 1: emission is shown
} u;
layout(binding = 1) uniform sampler2D position_image;                         // xyz m
layout(binding = 2) uniform sampler2D normal_image;                           // xyz unit
layout(binding = 3) uniform sampler2D albedo_image;                           // C_m
layout(binding = 4) uniform sampler2D emission_image;                         // M, W/m2
layout(std430, binding = 5) readonly buffer Id { ivec2 id[]; };               // object, triangle
layout(std430, binding = 6) readonly buffer Corners { ivec4 corners[]; };     // vertices A, B, C
layout(std430, binding = 7) readonly buffer Vertices { vec4 vertices[]; };    // two a vertex: xyz m; xyz normal
layout(std430, binding = 8) readonly buffer Kinds { ivec2 kinds[]; };         // material, object
layout(std430, binding = 9) readonly buffer Materials { vec4 materials[]; };  // two a material: C_m; C_s, n
layout(std430, binding = 10) readonly buffer Objects { vec4 objects[]; };     // six a mesh: rows of matrices
layout(std430, binding = 11) readonly buffer Lights { LightArgs lights[]; };
layout(binding = 12, rgba32f) uniform writeonly image2D irradiance_image;
layout(binding = 13, rgba32f) uniform writeonly image2D sent_image;

#include "gi/zbuffer/seen_triangle.glsl"
#include "gi/zbuffer/shade.glsl"

vec3 view_from(vec3 p) {
    precise vec3 to_eye = u.shade.eye.xyz - p;
    return unit_along(to_eye);
}

void pixel_light(ivec2 pixel) {
    vec3 x = texelFetch(position_image, pixel, 0).xyz;            TAP(x, x);
    SeenTriangle s = seen_triangle(pixel.y * u.width + pixel.x, x, u.shade.eye.xyz, u.triangles, u.vertices);
    ivec2 kind = kinds[s.at.x];
    int material = max(0, min(kind.x, u.shade.materials - 1));
    int object = max(0, min(kind.y, u.shade.objects - 1));

    vec3 n = texelFetch(normal_image, pixel, 0).xyz;
    vec3 v = view_from(x);
    if (u.normal != 0) {
        vec3 between = s.normal;
        if (u.shade.published != 0) {
            between = interpolated(turned(object, 0, vertices[s.at.x * 2 + 1].xyz), turned(object, 0, vertices[s.at.y * 2 + 1].xyz),
                                   turned(object, 0, vertices[s.at.z * 2 + 1].xyz), s.l);
            v = normalised(interpolated(view_from(vertices[s.at.x * 2].xyz), view_from(vertices[s.at.y * 2].xyz),
                                        view_from(vertices[s.at.z * 2].xyz), s.l));
        }
        precise vec3 taken = (u.normal == 1 ? normalised(between) : between) * s.side;
        n = taken;
    }
    TAP(n, n);
    TAP(v, v);
    vec4 k = materials[material * 2 + 1];                         TAP(exponent, k.w);
    vec3 specular;
    vec3 diffuse = lit_by(x, n, v, k.w, object, specular);
    colour(diffuse, specular, texelFetch(albedo_image, pixel, 0).xyz, k.xyz);
    vec3 m = texelFetch(emission_image, pixel, 0).xyz;
    precise vec3 all = float(u.emits) * m + specular;
    vec3 irradiance = s.seen ? diffuse : vec3(0.0);               TAP(irradiance, irradiance);
    vec3 sent = s.seen ? all : vec3(0.0);                         TAP(sent, sent);
    imageStore(irradiance_image, pixel, vec4(irradiance, 0.0));
    imageStore(sent_image, pixel, vec4(sent, 0.0));
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    TAP_BEGIN(pixel, 0);
    pixel_light(pixel);
}
