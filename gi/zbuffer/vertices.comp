#version 450
// Twin of vertices_kernel.h: light at vertices.
#extension GL_GOOGLE_include_directive : require
#include "core/detmath.glsl"
#include "core/tap.glsl"
#include "gi/zbuffer/shade_uniforms.glsl"
#include "raster/light.glsl"
#include "raster/arriving.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform VerticesUniforms {
    ShadeUniforms shade;
    int width;
    int height;
    int count;  // vertices
} u;
layout(std430, binding = 1) readonly buffer Vertices { vec4 vertices[]; };    // two a vertex: xyz m; xyz unit normal
layout(std430, binding = 2) readonly buffer Kinds { ivec2 kinds[]; };         // material, object
layout(std430, binding = 3) readonly buffer Materials { vec4 materials[]; };  // two a material: C_m; C_s, n
layout(std430, binding = 4) readonly buffer Objects { vec4 objects[]; };      // six a mesh: rows of matrices
layout(std430, binding = 5) readonly buffer Lights { LightArgs lights[]; };
layout(binding = 6, rgba32f) uniform writeonly image2D diffuse_image;
layout(binding = 7, rgba32f) uniform writeonly image2D specular_image;

#include "gi/zbuffer/shade.glsl"

void vertex_light(ivec2 at, int item) {
    bool front = item < u.count;
    int vertex = max(0, min(front ? item : item - u.count, u.count - 1));
    TAP(vertex, vertex);
    ivec2 kind = kinds[vertex];
    int material = max(0, min(kind.x, u.shade.materials - 1));
    int object = max(0, min(kind.y, u.shade.objects - 1));
    vec3 x = vertices[vertex * 2].xyz;                            TAP(x, x);
    vec3 n = vertices[vertex * 2 + 1].xyz;
    if (u.shade.published != 0) n = turned(object, 0, n);
    n = front ? n : -n;                                           TAP(n, n);
    precise vec3 to_eye = u.shade.eye.xyz - x;
    vec3 v = unit_along(to_eye);                                  TAP(v, v);
    vec4 k = materials[material * 2 + 1];                         TAP(exponent, k.w);
    vec3 specular;
    vec3 diffuse = lit_by(x, n, v, k.w, object, specular);
    colour(diffuse, specular, materials[material * 2].xyz, k.xyz);
    imageStore(diffuse_image, at, vec4(diffuse, 1.0));
    imageStore(specular_image, at, vec4(specular, 1.0));
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    int item = at.y * u.width + at.x;
    if (at.x >= u.width || at.y >= u.height || item >= 2 * u.count) return;
    TAP_BEGIN(at, 0);
    vertex_light(at, item);
}
