// Twin of surface_kernel.h: the same functions, in the same order. Every buffer is bound as the kernel reads it.

layout(std430, binding = 1) readonly buffer Vertices { vec4 vertices[]; };    // [vertex][2]: position m, u; normal, v
layout(std430, binding = 2) readonly buffer Triangles { int triangles[]; };   // [triangle][3]
layout(std430, binding = 3) readonly buffer TriangleMaterial { int triangle_material[]; };
layout(std430, binding = 4) readonly buffer Materials { vec4 materials[]; };  // [material][4]: surface_kernel.h
layout(std430, binding = 5) readonly buffer Tangents { vec4 tangents[]; };    // [vertex]; w: side of the bitangent
layout(std430, binding = 6) readonly buffer Textures { ivec4 textures[]; };   // first texel, width, height, flags
layout(std430, binding = 7) readonly buffer Texels { int texels[]; };         // RGBA8
layout(std430, binding = 8) readonly buffer Decode { float decode[]; };       // [2][256]

const int flag_nearest = 1;
const int flag_srgb = 2;
const int wrap_u_shift = 2;
const int wrap_v_shift = 4;

struct Surface {
    vec3 position;
    vec3 normal;
    vec3 albedo;
    vec3 emission;
};

float dot3(vec3 a, vec3 b) {
    precise float sum = a.x * b.x + a.y * b.y + a.z * b.z;
    return sum;
}

float largest3(vec3 v) { return max(abs(v.x), max(abs(v.y), abs(v.z))); }

float interpolate(float a, float e1, float e2, vec2 l) {
    precise float value = a + (e1 * l.x + e2 * l.y);
    return value;
}
vec3 interpolate3(vec3 a, vec3 e1, vec3 e2, vec2 l) {
    return vec3(interpolate(a.x, e1.x, e2.x, l), interpolate(a.y, e1.y, e2.y, l), interpolate(a.z, e1.z, e2.z, l));
}

vec3 face_normal(vec3 e1, vec3 e2) {
    precise float scale = 1.0 / max(max(largest3(e1), largest3(e2)), 1e-37);
    precise vec3 a = e1 * scale;
    precise vec3 b = e2 * scale;
    precise vec3 n = vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
    return n;
}

float side_of(float x) { return x < 0.0 ? -1.0 : 1.0; }

float viewed_side(vec3 face, vec3 n, vec3 to_viewer) {
    precise float side = side_of(dot3(face, to_viewer)) * side_of(dot3(face, n));
    return side;
}

vec3 normalised(vec3 n) {
    precise float length_n = max(sqrt(dot3(n, n)), 1e-30);
    precise vec3 unit = vec3(n.x / length_n, n.y / length_n, n.z / length_n);
    return unit;
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

float texel_coordinate(float u, int size, int wrap, bool nearest) {
    bool mirrored = wrap == 1;
    bool clamped = wrap == 2;
    precise float periods = u * (mirrored ? 0.5 : 1.0);
    precise float within = clamped ? min(max(u, 0.0), 1.0) : periods - floor(periods);
    precise float along = within * float(mirrored ? size + size : size);
    precise float coordinate = nearest ? floor(along) : along - 0.5;
    return abs(u) <= 3.40282347e+38 ? coordinate : 0.0;
}

int wrap_index(int i, int size, int wrap) {
    bool mirrored = wrap == 1;
    bool clamped = wrap == 2;
    int below = mirrored ? -1 - i : i + size;
    int above = mirrored ? size + size - 1 - i : i - size;
    int folded = i < 0 ? below : (i < size ? i : above);
    return min(max(clamped ? i : folded, 0), size - 1);
}

struct TexelQuad {
    int a;
    int b;
    int c;
    int d;
    float along_u;
    float along_v;
    int curve;
};

TexelQuad fetch_quad(int row, vec2 uv) {
    int first = textures[row].x;
    int width = textures[row].y;
    int height = textures[row].z;
    int flags = textures[row].w;
    int wrap_u = (flags >> wrap_u_shift) & 3;
    int wrap_v = (flags >> wrap_v_shift) & 3;
    bool nearest = (flags & flag_nearest) > 0;

    float x = texel_coordinate(uv.x, width, wrap_u, nearest);
    float y = texel_coordinate(uv.y, height, wrap_v, nearest);
    float left = floor(x);
    float top = floor(y);
    int i = int(left);
    int j = int(top);
    int x0 = wrap_index(i, width, wrap_u);
    int x1 = wrap_index(i + 1, width, wrap_u);
    int upper = first + wrap_index(j, height, wrap_v) * width;
    int lower = first + wrap_index(j + 1, height, wrap_v) * width;
    precise float along_u = x - left;
    precise float along_v = y - top;
    return TexelQuad(texels[upper + x0], texels[upper + x1], texels[lower + x0], texels[lower + x1], along_u, along_v,
                     (flags & flag_srgb) << 7);
}

float filter_channel(TexelQuad q, int curve, int channel) {
    float a = decode[curve + ((q.a >> (8 * channel)) & 255)];
    float b = decode[curve + ((q.b >> (8 * channel)) & 255)];
    float c = decode[curve + ((q.c >> (8 * channel)) & 255)];
    float d = decode[curve + ((q.d >> (8 * channel)) & 255)];
    precise float upper = a + q.along_u * (b - a);
    precise float lower = c + q.along_u * (d - c);
    precise float value = upper + q.along_v * (lower - upper);
    return value;
}
vec3 filter_rgb(TexelQuad q, int curve) {
    return vec3(filter_channel(q, curve, 0), filter_channel(q, curve, 1), filter_channel(q, curve, 2));
}

vec3 times3(vec3 a, vec3 b) {
    precise vec3 product = a * b;
    return product;
}

vec3 mapped_normal(MaterialRow m, int v0, int v1, int v2, vec2 uv, vec2 l, vec3 n) {
    vec4 t0 = tangents[v0];
    vec4 t1 = tangents[v1];
    vec4 t2 = tangents[v2];
    precise vec4 dt1 = t1 - t0;
    precise vec4 dt2 = t2 - t0;
    vec3 tangent = interpolate3(t0.xyz, dt1.xyz, dt2.xyz, l);
    float side = interpolate(t0.w, dt1.w, dt2.w, l);

    TexelQuad q = fetch_quad(m.normal, uv);
    vec3 texel = filter_rgb(q, 0);
    precise float x = (2.0 * texel.x - 1.0) * m.normal_scale;
    precise float y = (2.0 * texel.y - 1.0) * m.normal_scale;
    precise float z = 2.0 * texel.z - 1.0;
    precise float w = y * side;
    precise vec3 across = vec3(n.y * tangent.z - n.z * tangent.y, n.z * tangent.x - n.x * tangent.z,
                               n.x * tangent.y - n.y * tangent.x);
    precise vec3 mapped = vec3((x * tangent.x + w * across.x) + z * n.x, (x * tangent.y + w * across.y) + z * n.y,
                               (x * tangent.z + w * across.z) + z * n.z);
    return mapped;
}

vec2 interpolate_uv(vec2 a, vec2 b, vec2 c, vec2 l) {
    precise vec2 d1 = b - a;
    precise vec2 d2 = c - a;
    return vec2(interpolate(a.x, d1.x, d2.x, l), interpolate(a.y, d1.y, d2.y, l));
}

// Whether there is a surface at all. A fragment stage that draws a masked material discards where there is none.
bool passes_alpha(int triangle, vec2 l) {
    MaterialRow m = fetch_material(triangle_material[triangle]);
    int v0 = triangles[triangle * 3] * 2;
    int v1 = triangles[triangle * 3 + 1] * 2;
    int v2 = triangles[triangle * 3 + 2] * 2;
    vec2 uv = interpolate_uv(vec2(vertices[v0].w, vertices[v0 + 1].w), vec2(vertices[v1].w, vertices[v1 + 1].w),
                             vec2(vertices[v2].w, vertices[v2 + 1].w), l);
    TexelQuad q = fetch_quad(m.base, uv);
    precise float alpha = m.reflectance_alpha.w * filter_channel(q, 0, 3);
    float cutoff = m.emission_cutoff.w;
    return !(cutoff > 0.0) || alpha >= cutoff;
}

// viewer: xyz m, w 1: where the viewer is; w 0: the direction towards it.
Surface surface(int triangle, vec2 l, vec4 viewer) {
    int v0 = triangles[triangle * 3];
    int v1 = triangles[triangle * 3 + 1];
    int v2 = triangles[triangle * 3 + 2];
    vec4 p0 = vertices[v0 * 2];
    vec4 p1 = vertices[v1 * 2];
    vec4 p2 = vertices[v2 * 2];
    vec4 n0 = vertices[v0 * 2 + 1];
    vec4 n1 = vertices[v1 * 2 + 1];
    vec4 n2 = vertices[v2 * 2 + 1];
    MaterialRow m = fetch_material(triangle_material[triangle]);

    Surface s;
    precise vec3 e1 = p1.xyz - p0.xyz;
    precise vec3 e2 = p2.xyz - p0.xyz;
    s.position = interpolate3(p0.xyz, e1, e2, l);

    precise vec3 to_viewer = vec3(viewer.x - viewer.w * p0.x, viewer.y - viewer.w * p0.y, viewer.z - viewer.w * p0.z);
    precise vec3 dn1 = n1.xyz - n0.xyz;
    precise vec3 dn2 = n2.xyz - n0.xyz;
    vec3 interpolated = interpolate3(n0.xyz, dn1, dn2, l);
    vec3 face = face_normal(e1, e2);
    bool given = dot3(interpolated, interpolated) > 0.0;
    vec3 n = given ? interpolated : face;
    float side = viewed_side(face, n, to_viewer);

    vec2 uv = vec2(0.0);
    if ((m.base | m.emission | m.normal) > 0)
        uv = interpolate_uv(vec2(p0.w, n0.w), vec2(p1.w, n1.w), vec2(p2.w, n2.w), l);
    if (m.normal > 0) {
        vec3 unit = given ? n : normalised(face);
        n = mapped_normal(m, v0, v1, v2, uv, l, unit);
    }
    precise vec3 seen = normalised(n) * side;
    s.normal = seen;

    s.albedo = m.reflectance_alpha.xyz;
    if (m.base > 0) {
        TexelQuad q = fetch_quad(m.base, uv);
        s.albedo = times3(s.albedo, filter_rgb(q, q.curve));
    }
    s.emission = m.emission_cutoff.xyz;
    if (m.emission > 0) {
        TexelQuad q = fetch_quad(m.emission, uv);
        s.emission = times3(s.emission, filter_rgb(q, q.curve));
    }
    return s;
}

float linear_depth(vec3 eye, vec3 forward, vec3 x) {
    precise vec3 d = x - eye;
    return dot3(forward, d);
}
