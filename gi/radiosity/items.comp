#version 450
// Twin of items_kernel.h: which triangle each texel of a hemicube sees.
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform ItemsUniforms {
    int width;      // texels of a face's side
    int height;     // of all rows of all hemicubes
    int vertices;
    int triangles;
    float texel;    // 2 / width
    float slack;    // how far beyond its corners a triangle may reach
} u;
layout(std430, binding = 1) readonly buffer Eyes { vec4 eyes[]; };
layout(std430, binding = 2) readonly buffer Vertices { vec4 vertices[]; };
layout(std430, binding = 3) readonly buffer Triangles { ivec4 triangles[]; };
layout(std430, binding = 4) writeonly buffer TriangleSeen { int triangle[]; };
layout(std430, binding = 5) writeonly buffer SeenAt { vec4 seen[]; };

struct Item {
    int triangle;  // -1: none
    vec4 seen;     // barycentrics of corners 1 and 2, 1/depth, 1: its front, -1: its back
};

float dot_of(vec3 a, vec3 b) {
    precise float sum = a.x * b.x + a.y * b.y + a.z * b.z;
    return sum;
}
vec3 cross_of(vec3 a, vec3 b) {
    precise vec3 c = vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
    return c;
}
vec3 minus(vec3 a, vec3 b) {
    precise vec3 d = a - b;
    return d;
}

// In the axes of the hemicube: along u, t, n.
vec3 along(vec3 d, int first) {
    return vec3(dot_of(d, eyes[first + 1].xyz), dot_of(d, eyes[first + 2].xyz), dot_of(d, eyes[first + 3].xyz));
}

// From those to a face's right, up, forward.
vec3 turned(vec3 p, int face) {
    if (face == 0) return vec3(-p.y, p.x, p.z);
    if (face == 1) return vec3(p.y, p.z, p.x);
    if (face == 2) return vec3(-p.y, p.z, -p.x);
    if (face == 3) return vec3(-p.x, p.z, p.y);
    return vec3(p.x, p.z, -p.y);
}

float plane_at(vec3 e, float x, float y) {
    precise float value = e.x * x + (e.y * y + e.z);
    return value;
}

bool reaches(vec3 a, vec3 b, vec3 c) {
    if (!(a.z > 0.0 || b.z > 0.0 || c.z > 0.0)) return false;
    if (a.x > a.z && b.x > b.z && c.x > c.z) return false;
    if (-a.x > a.z && -b.x > b.z && -c.x > c.z) return false;
    if (a.y > a.z && b.y > b.z && c.y > c.z) return false;
    return !(-a.y > a.z && -b.y > b.z && -c.y > c.z);
}

bool within_bounds(vec3 a, vec3 b, vec3 c, float x, float y) {
    if (!(a.z > 0.0 && b.z > 0.0 && c.z > 0.0)) return true;
    precise vec3 xs = vec3(a.x / a.z, b.x / b.z, c.x / c.z);
    precise vec3 ys = vec3(a.y / a.z, b.y / b.z, c.y / c.z);
    precise float left = min(min(xs.x, xs.y), xs.z) - u.slack;
    precise float right = max(max(xs.x, xs.y), xs.z) + u.slack;
    precise float bottom = min(min(ys.x, ys.y), ys.z) - u.slack;
    precise float top = max(max(ys.x, ys.y), ys.z) + u.slack;
    return left <= x && x <= right && bottom <= y && y <= top;
}

Item item(ivec2 at) {
    int rows = 3 * u.width;
    int half_width = u.width / 2;
    int hemicube = at.y / rows;
    int row = at.y - hemicube * rows;
    int face = row < u.width ? 0 : 1 + (row - u.width) / half_width;
    int own = face == 0 ? row : row - u.width - (face - 1) * half_width;
    precise float x = (float(at.x) + 0.5) * u.texel - 1.0;
    precise float y = 1.0 - (float(own) + 0.5) * u.texel;
    TAP(face, face);
    TAP(x, x);
    TAP(y, y);
    int first = hemicube * 4;
    Item nearest = Item(-1, vec4(0.0));
    for (int i = 0; i < u.triangles; ++i) {
        ivec4 corner = triangles[i];
        if (min(min(corner.x, corner.y), corner.z) < 0 || max(max(corner.x, corner.y), corner.z) >= u.vertices) continue;
        vec3 v0 = vertices[corner.x].xyz;
        vec3 v1 = vertices[corner.y].xyz;
        vec3 v2 = vertices[corner.z].xyz;
        vec3 d0 = minus(v0, eyes[first].xyz);
        vec3 p0 = along(d0, first);
        vec3 p1 = along(minus(v1, eyes[first].xyz), first);
        vec3 p2 = along(minus(v2, eyes[first].xyz), first);
        if (!(p0.z > 0.0 || p1.z > 0.0 || p2.z > 0.0)) continue;
        vec3 q0 = turned(p0, face);
        vec3 q1 = turned(p1, face);
        vec3 q2 = turned(p2, face);
        if (!reaches(q0, q1, q2) || !within_bounds(q0, q1, q2, x, y)) continue;
        TAP_SAMPLE(i);
        vec3 normal = cross_of(minus(v2, v0), minus(v1, v0));  // u, t, n are left-handed
        float volume = dot_of(normal, d0);
        precise float e0 = plane_at(turned(cross_of(p1, p2), face), x, y);
        precise float e1 = plane_at(turned(cross_of(p2, p0), face), x, y);
        precise float e2 = plane_at(turned(cross_of(p0, p1), face), x, y);
        precise float inverse_volume = 1.0 / volume;
        precise float nearness = plane_at(turned(along(normal, first), face), x, y) * inverse_volume;
        TAP(volume, volume);
        TAP(e, vec3(e0, e1, e2));
        TAP(nearness, nearness);
        bool front = volume > 0.0;
        bool covered = front ? e0 >= 0.0 && e1 >= 0.0 && e2 >= 0.0 : volume < 0.0 && e0 <= 0.0 && e1 <= 0.0 && e2 <= 0.0;
        if (!covered || !(nearness > nearest.seen.z)) continue;
        precise float sum = abs(e0) + abs(e1) + abs(e2);
        precise float scale = 1.0 / (sum > 0.0 ? sum : 1.0);
        precise float b1 = abs(e1) * scale;
        precise float b2 = abs(e2) * scale;
        nearest = Item(i, vec4(b1, b2, nearness, front ? 1.0 : -1.0));
    }
    TAP_SAMPLE(-1);
    TAP(triangle, nearest.triangle);
    TAP(seen, nearest.seen.xyz);
    TAP(side, nearest.seen.w);
    return nearest;
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (at.x >= u.width || at.y >= u.height) return;
    TAP_BEGIN(at, 0);
    Item i = item(at);
    triangle[at.y * u.width + at.x] = i.triangle;
    seen[at.y * u.width + at.x] = i.seen;
}
