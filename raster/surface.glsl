// Twin of surface_kernel.h: the same functions, in the same order. Every buffer is bound as the kernel reads it.
#include "raster/normal.glsl"
#include "raster/texture.glsl"

layout(std430, binding = 1) readonly buffer Vertices { vec4 vertices[]; };    // [vertex][2]: position m, u; normal, v
layout(std430, binding = 2) readonly buffer Triangles { int triangles[]; };   // [triangle][3]
layout(std430, binding = 3) readonly buffer TriangleMaterial { int triangle_material[]; };
layout(std430, binding = 4) readonly buffer Materials { vec4 materials[]; };  // [material][4]: surface_kernel.h
layout(std430, binding = 5) readonly buffer Tangents { vec4 tangents[]; };    // [vertex]; w: side of the bitangent

// Whether any material may be masked. Specialised to false, a pipeline has no discard, and may test depth early.
layout(constant_id = 0) const bool masks = true;

// SurfaceArgs' last members.
struct Viewer {
    vec4 place;        // xyz m, w 1: where the viewer is; w 0: the direction towards it
    vec3 forward;      // unit: where the viewer looks
    float pixel_area;  // of a pixel: at depth 1 m, m2/m2; parallel projection: m2; 0: level 0 of every texture
};

struct Surface {
    vec3 position;
    vec3 normal;
    vec3 albedo;
    vec3 emission;
};

float interpolate(float a, float e1, float e2, vec2 l) {
    precise float value = a + (e1 * l.x + e2 * l.y);
    return value;
}
vec3 interpolate3(vec3 a, vec3 e1, vec3 e2, vec2 l) {
    return vec3(interpolate(a.x, e1.x, e2.x, l), interpolate(a.y, e1.y, e2.y, l), interpolate(a.z, e1.z, e2.z, l));
}

float side_of(float x) { return x < 0.0 ? -1.0 : 1.0; }

float viewed_side(vec3 face, vec3 n, vec3 to_viewer) {
    precise float side = side_of(dot3(face, to_viewer)) * side_of(dot3(face, n));
    return side;
}

struct MaterialRow {
    vec4 reflectance_alpha;
    vec4 emission_cutoff;
    int base;
    int emission;
    int normal;
    float normal_scale;
};

MaterialRow fetch_material(int material) {
    vec4 rows = materials[material * 4 + 2];
    return MaterialRow(materials[material * 4], materials[material * 4 + 1], int(rows.x), int(rows.y), int(rows.z),
                       rows.w);
}

vec3 times3(vec3 a, vec3 b) {
    precise vec3 product = a * b;
    return product;
}

vec3 mapped_normal(MaterialRow m, int v0, int v1, int v2, vec2 uv, float uv_area, bool levels, vec2 l, vec3 n) {
    vec4 t0 = tangents[v0];
    vec4 t1 = tangents[v1];
    vec4 t2 = tangents[v2];
    precise vec4 dt1 = t1 - t0;
    precise vec4 dt2 = t2 - t0;
    vec3 tangent = interpolate3(t0.xyz, dt1.xyz, dt2.xyz, l);
    float side = interpolate(t0.w, dt1.w, dt2.w, l);
    TAP(tangent, tangent);
    TAP(bitangent_side, side);

    TAP_OFF;
    vec3 texel = sample_texture(m.normal, uv, uv_area, levels, true);
    TAP_ON;
    precise float x = (2.0 * texel.x - 1.0) * m.normal_scale;
    precise float y = (2.0 * texel.y - 1.0) * m.normal_scale;
    precise float z = 2.0 * texel.z - 1.0;
    precise float w = y * side;
    TAP(tangent_normal, vec3(x, y, z));
    vec3 across = cross3(n, tangent);
    precise vec3 mapped = vec3((x * tangent.x + w * across.x) + z * n.x, (x * tangent.y + w * across.y) + z * n.y,
                               (x * tangent.z + w * across.z) + z * n.z);
    return mapped;
}

vec2 interpolate_uv(vec2 a, vec2 b, vec2 c, vec2 l) {
    precise vec2 d1 = b - a;
    precise vec2 d2 = c - a;
    return vec2(interpolate(a.x, d1.x, d2.x, l), interpolate(a.y, d1.y, d2.y, l));
}

// Area in (u, v) that a pixel covers.
float pixel_uv_area(Viewer viewer, vec2 uv1, vec2 uv2, vec3 e1, vec3 e2, vec3 to_viewer, vec3 x) {
    precise float area = viewer.pixel_area;
    if (viewer.place.w > 0.0) {
        precise vec3 d = x - viewer.place.xyz;
        float depth = dot3(viewer.forward, d);
        area = area * (depth * depth * depth);
    }
    precise float covered = area * abs(uv1.x * uv2.y - uv1.y * uv2.x) / abs(dot3(cross3(e1, e2), to_viewer));
    return covered;
}

bool is_masked(int triangle) { return fetch_material(triangle_material[triangle]).emission_cutoff.w > 0.0; }

// Whether there is a surface at all.
bool passes_alpha(int triangle, vec2 l) {
    MaterialRow m = fetch_material(triangle_material[triangle]);
    int v0 = triangles[triangle * 3] * 2;
    int v1 = triangles[triangle * 3 + 1] * 2;
    int v2 = triangles[triangle * 3 + 2] * 2;
    vec2 uv = interpolate_uv(vec2(vertices[v0].w, vertices[v0 + 1].w), vec2(vertices[v1].w, vertices[v1 + 1].w),
                             vec2(vertices[v2].w, vertices[v2 + 1].w), l);
    TAP_OFF;
    TexelQuad q = fetch_quad(m.base, uv);
    TAP_ON;
    precise float alpha = m.reflectance_alpha.w * filter_channel(q, 0, 3);
    float cutoff = m.emission_cutoff.w;
    return !(cutoff > 0.0) || alpha >= cutoff;
}

Surface surface(int triangle, vec2 l, Viewer viewer) {
    TAP(triangle, triangle);
    TAP(barycentrics, l);
    int v0 = triangles[triangle * 3];
    int v1 = triangles[triangle * 3 + 1];
    int v2 = triangles[triangle * 3 + 2];
    vec4 p0 = vertices[v0 * 2];
    vec4 p1 = vertices[v1 * 2];
    vec4 p2 = vertices[v2 * 2];
    vec4 n0 = vertices[v0 * 2 + 1];
    vec4 n1 = vertices[v1 * 2 + 1];
    vec4 n2 = vertices[v2 * 2 + 1];
    int material = triangle_material[triangle];                                TAP(material, material);
    MaterialRow m = fetch_material(material);

    Surface s;
    precise vec3 e1 = p1.xyz - p0.xyz;
    precise vec3 e2 = p2.xyz - p0.xyz;
    s.position = interpolate3(p0.xyz, e1, e2, l);                              TAP(position, s.position);

    precise vec3 to_viewer = viewer.place.xyz - viewer.place.w * p0.xyz;
    precise vec3 dn1 = n1.xyz - n0.xyz;
    precise vec3 dn2 = n2.xyz - n0.xyz;
    vec3 interpolated = interpolate3(n0.xyz, dn1, dn2, l);
    vec3 face = face_normal(e1, e2);
    bool given = dot3(interpolated, interpolated) > 0.0;
    vec3 n = given ? interpolated : face;
    float side = viewed_side(face, n, to_viewer);

    vec2 uv = vec2(0.0);
    float uv_area = 0.0;
    bool levels = viewer.pixel_area > 0.0;
    if ((m.base | m.emission | m.normal) > 0) {
        uv = interpolate_uv(vec2(p0.w, n0.w), vec2(p1.w, n1.w), vec2(p2.w, n2.w), l);
        TAP(uv, uv);
        if (levels) {
            precise vec2 uv1 = vec2(p1.w - p0.w, n1.w - n0.w);
            precise vec2 uv2 = vec2(p2.w - p0.w, n2.w - n0.w);
            uv_area = pixel_uv_area(viewer, uv1, uv2, e1, e2, to_viewer, s.position);
            TAP(uv_area, uv_area);
        }
    }
    if (m.normal > 0) {
        vec3 unit = given ? n : normalised(face);
        n = mapped_normal(m, v0, v1, v2, uv, uv_area, levels, l, unit);
    }
    precise vec3 seen = normalised(n) * side;
    s.normal = seen;                                                           TAP(normal, s.normal);

    s.albedo = m.reflectance_alpha.xyz;                                        TAP(reflectance, s.albedo);
    if (m.base > 0) {
        vec3 colour = sample_texture(m.base, uv, uv_area, levels, false);      TAP(texture, colour);
        s.albedo = times3(s.albedo, colour);
    }
    TAP(albedo, s.albedo);

    s.emission = m.emission_cutoff.xyz;
    TAP_OFF;
    if (m.emission > 0) s.emission = times3(s.emission, sample_texture(m.emission, uv, uv_area, levels, false));
    TAP_ON;
    TAP(emission, s.emission);
    return s;
}

float linear_depth(vec3 eye, vec3 forward, vec3 x) {
    precise vec3 d = x - eye;
    return dot3(forward, d);
}
