// Twin of SeenTriangle of interpolate_kernel.h. Before it: `id[]`, `corners[]`, `vertices[]`, raster/barycentric.glsl.

struct SeenTriangle {
    bool seen;
    ivec3 at;     // vertices A, B, C
    vec2 l;       // barycentrics of B and C
    vec3 normal;  // interpolated, of any length
    float side;   // +1, or -1: what is seen is the back of its normals
};

float largest_of(vec3 v) { return max(abs(v.x), max(abs(v.y), abs(v.z))); }
float side_of(float x) { return x < 0.0 ? -1.0 : 1.0; }

SeenTriangle seen_triangle(int pixel, vec3 p, vec3 eye, int triangles, int vertex_count) {
    SeenTriangle s;
    int triangle = id[pixel].y;                                   TAP(triangle, triangle);
    s.seen = triangle >= 0 && triangle < triangles;
    ivec4 corner = corners[max(0, min(triangle, triangles - 1))];
    s.at = max(ivec3(0), min(corner.xyz, ivec3(vertex_count - 1)));
    vec3 p_a = vertices[s.at.x * 2].xyz;
    precise vec3 e1 = vertices[s.at.y * 2].xyz - p_a;
    precise vec3 e2 = vertices[s.at.z * 2].xyz - p_a;
    precise float scale = 1.0 / max(max(largest_of(e1), largest_of(e2)), 1e-37);
    precise vec3 edge1 = e1 * scale;
    precise vec3 edge2 = e2 * scale;
    precise vec3 d = (p - p_a) * scale;
    if (!(largest_of(d) <= 1024.0)) d = vec3(0.0);
    s.l = barycentrics_of(d, edge1, edge2);                       TAP(barycentrics, s.l);
    s.normal = interpolated(vertices[s.at.x * 2 + 1].xyz, vertices[s.at.y * 2 + 1].xyz, vertices[s.at.z * 2 + 1].xyz, s.l);
    vec3 face = cross_of(edge1, edge2);
    precise vec3 to_viewer = eye - p_a;
    vec3 n = dot_of(s.normal, s.normal) > 0.0 ? s.normal : face;
    precise float side = side_of(dot_of(face, to_viewer)) * side_of(dot_of(face, n));
    s.side = side;
    TAP(side, s.side);
    return s;
}
