// Twin of surface_kernel.h: the same functions, in the same order. Every buffer is bound as the kernel reads it.

layout(std430, binding = 1) readonly buffer Vertices { vec4 vertices[]; };    // [vertex][2]: position m, u; normal, v
layout(std430, binding = 2) readonly buffer Triangles { int triangles[]; };   // [triangle][3]
layout(std430, binding = 3) readonly buffer TriangleMaterial { int triangle_material[]; };
layout(std430, binding = 4) readonly buffer Materials { vec4 materials[]; };  // [material][4]: reflectance; emission
layout(std430, binding = 5) readonly buffer MaterialTexture { int material_texture[]; };
layout(std430, binding = 6) readonly buffer Textures { ivec4 textures[]; };   // first texel, width, height, flags
layout(std430, binding = 7) readonly buffer Texels { int texels[]; };         // RGBA8
layout(std430, binding = 8) readonly buffer Decode { float decode[]; };       // [2][256]

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

vec3 viewed_normal(vec3 interpolated, vec3 face, vec3 to_viewer) {
    bool given = dot3(interpolated, interpolated) > 0.0;
    vec3 n = given ? interpolated : face;
    precise float length_n = max(sqrt(dot3(n, n)), 1e-30);
    float side = side_of(dot3(face, to_viewer)) * side_of(dot3(face, n));
    precise vec3 unit = vec3(n.x / length_n * side, n.y / length_n * side, n.z / length_n * side);
    return unit;
}

int repeat(int i, int size) {
    int up = i < 0 ? i + size : i;
    return up >= size ? up - size : up;
}

vec3 fetch_texel(int at, int curve) {
    int texel = texels[at];
    return vec3(decode[curve + (texel & 255)], decode[curve + ((texel >> 8) & 255)],
                decode[curve + ((texel >> 16) & 255)]);
}

float texture_coordinate(float u, int size, bool nearest) {
    precise float along = (u - floor(u)) * float(size);
    precise float coordinate = nearest ? floor(along) : along - 0.5;
    return coordinate;
}

float filter_texels(float a, float b, float c, float d, float along_u, float along_v) {
    precise float upper = a + along_u * (b - a);
    precise float lower = c + along_u * (d - c);
    precise float value = upper + along_v * (lower - upper);
    return value;
}

vec3 sample_texture(int row, vec2 uv) {
    int first = textures[row].x;
    int width = textures[row].y;
    int height = textures[row].z;
    int flags = textures[row].w;
    int curve = (flags & 2) << 7;
    bool nearest = (flags & 1) > 0;

    float x = texture_coordinate(uv.x, width, nearest);
    float y = texture_coordinate(uv.y, height, nearest);
    float left = floor(x);
    float top = floor(y);
    precise float along_u = x - left;
    precise float along_v = y - top;

    int x0 = repeat(min(max(int(left), -1), width), width);
    int y0 = repeat(min(max(int(top), -1), height), height);
    int x1 = repeat(x0 + 1, width);
    int y1 = repeat(y0 + 1, height);

    vec3 a = fetch_texel(first + y0 * width + x0, curve);
    vec3 b = fetch_texel(first + y0 * width + x1, curve);
    vec3 c = fetch_texel(first + y1 * width + x0, curve);
    vec3 d = fetch_texel(first + y1 * width + x1, curve);
    return vec3(filter_texels(a.x, b.x, c.x, d.x, along_u, along_v),
                filter_texels(a.y, b.y, c.y, d.y, along_u, along_v),
                filter_texels(a.z, b.z, c.z, d.z, along_u, along_v));
}

// viewer: xyz m, w 1: where the viewer is; w 0: the direction towards it.
Surface surface(int triangle, vec2 l, vec4 viewer) {
    int v0 = triangles[triangle * 3] * 2;
    int v1 = triangles[triangle * 3 + 1] * 2;
    int v2 = triangles[triangle * 3 + 2] * 2;
    vec4 p0 = vertices[v0];
    vec4 p1 = vertices[v1];
    vec4 p2 = vertices[v2];
    vec4 n0 = vertices[v0 + 1];
    vec4 n1 = vertices[v1 + 1];
    vec4 n2 = vertices[v2 + 1];

    Surface s;
    precise vec3 e1 = p1.xyz - p0.xyz;
    precise vec3 e2 = p2.xyz - p0.xyz;
    s.position = interpolate3(p0.xyz, e1, e2, l);

    precise vec3 to_viewer = vec3(viewer.x - viewer.w * p0.x, viewer.y - viewer.w * p0.y, viewer.z - viewer.w * p0.z);
    precise vec3 dn1 = n1.xyz - n0.xyz;
    precise vec3 dn2 = n2.xyz - n0.xyz;
    vec3 interpolated = interpolate3(n0.xyz, dn1, dn2, l);
    s.normal = viewed_normal(interpolated, face_normal(e1, e2), to_viewer);

    int material = triangle_material[triangle];
    vec3 reflectance = materials[material * 4].xyz;
    s.emission = materials[material * 4 + 1].xyz;
    s.albedo = reflectance;
    int row = material_texture[material];
    if (row > 0) {
        precise vec2 du = vec2(p1.w - p0.w, p2.w - p0.w);
        precise vec2 dv = vec2(n1.w - n0.w, n2.w - n0.w);
        vec2 uv = vec2(interpolate(p0.w, du.x, du.y, l), interpolate(n0.w, dv.x, dv.y, l));
        vec3 colour = sample_texture(row, uv);
        precise vec3 albedo = reflectance * colour;
        s.albedo = albedo;
    }
    return s;
}

float linear_depth(vec3 eye, vec3 forward, vec3 x) {
    precise vec3 d = x - eye;
    return dot3(forward, d);
}
