// Twin of barycentric_kernel.h: where in a triangle a point lies.

float dot_of(vec3 a, vec3 b) {
    precise float d = a.x * b.x + a.y * b.y + a.z * b.z;
    return d;
}

vec3 cross_of(vec3 a, vec3 b) {
    precise vec3 c = vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
    return c;
}

// Of B and of C; d = p - A.
vec2 barycentrics_of(vec3 d, vec3 e1, vec3 e2) {
    vec3 n = cross_of(e1, e2);
    float area = dot_of(n, n);
    precise float scale = 1.0 / (area > 0.0 ? area : 1.0);
    precise float b = max(0.0, min(dot_of(cross_of(d, e2), n) * scale, 1.0));
    precise float c = max(0.0, min(dot_of(cross_of(e1, d), n) * scale, 1.0 - b));
    return vec2(b, c);
}

// a + l1 (b - a) + l2 (c - a): exact where a, b and c agree.
vec3 interpolated(vec3 a, vec3 b, vec3 c, vec2 l) {
    precise vec3 at = a + ((b - a) * l.x + (c - a) * l.y);
    return at;
}
