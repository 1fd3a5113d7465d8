#version 450
// Twin of interpolate_kernel.h: what a pixel sees of the light at its triangle's vertices.
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"
#include "raster/barycentric.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform InterpolateUniforms {
    int width;
    int height;
    int triangles;  // that id counts
    int vertices;
    int row;        // items a row of the vertices' light
    int emits;      // 1: emission is shown
    vec4 eye;
} u;
layout(binding = 1) uniform sampler2D position_image;                       // xyz m
layout(std430, binding = 2) readonly buffer Id { ivec2 id[]; };             // object, triangle
layout(binding = 3) uniform sampler2D emission_image;                       // M, W/m2
layout(std430, binding = 4) readonly buffer Corners { ivec4 corners[]; };   // vertices A, B, C
layout(std430, binding = 5) readonly buffer Vertices { vec4 vertices[]; };  // two a vertex: xyz m; xyz normal
layout(binding = 6) uniform sampler2D vertex_diffuse_image;                 // of vertices: fronts, backs, W/m2
layout(binding = 7) uniform sampler2D vertex_specular_image;                // the same
layout(binding = 8, rgba32f) uniform writeonly image2D irradiance_image;
layout(binding = 9, rgba32f) uniform writeonly image2D sent_image;

#include "gi/zbuffer/seen_triangle.glsl"

ivec2 place_of(int item) { return ivec2(item % u.row, item / u.row); }

void interpolate_light(ivec2 pixel) {
    vec3 p = texelFetch(position_image, pixel, 0).xyz;
    SeenTriangle s = seen_triangle(pixel.y * u.width + pixel.x, p, u.eye.xyz, u.triangles, u.vertices);
    ivec3 at = s.at + ivec3(s.side < 0.0 ? u.vertices : 0);
    ivec2 a = place_of(at.x);
    ivec2 b = place_of(at.y);
    ivec2 c = place_of(at.z);
    vec3 light = interpolated(texelFetch(vertex_diffuse_image, a, 0).xyz, texelFetch(vertex_diffuse_image, b, 0).xyz,
                              texelFetch(vertex_diffuse_image, c, 0).xyz, s.l);
    vec3 irradiance = s.seen ? light : vec3(0.0);                 TAP(irradiance, irradiance);
    vec3 highlight = interpolated(texelFetch(vertex_specular_image, a, 0).xyz, texelFetch(vertex_specular_image, b, 0).xyz,
                                  texelFetch(vertex_specular_image, c, 0).xyz, s.l);
    TAP(highlight, highlight);
    vec3 m = texelFetch(emission_image, pixel, 0).xyz;
    precise vec3 all = float(u.emits) * m + highlight;
    vec3 sent = s.seen ? all : vec3(0.0);                         TAP(sent, sent);
    imageStore(irradiance_image, pixel, vec4(irradiance, 0.0));
    imageStore(sent_image, pixel, vec4(sent, 0.0));
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    TAP_BEGIN(pixel, 0);
    interpolate_light(pixel);
}
