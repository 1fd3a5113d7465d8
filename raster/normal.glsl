// Of surface_kernel.h: the normal that two edges span. It binds nothing, so that any twin may include it.

float dot3(vec3 a, vec3 b) {
    precise float sum = a.x * b.x + a.y * b.y + a.z * b.z;
    return sum;
}

float largest3(vec3 v) { return max(abs(v.x), max(abs(v.y), abs(v.z))); }

vec3 cross3(vec3 a, vec3 b) {
    precise vec3 c = vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
    return c;
}

vec3 face_normal(vec3 e1, vec3 e2) {
    precise float scale = 1.0 / max(max(largest3(e1), largest3(e2)), 1e-37);
    precise vec3 a = e1 * scale;
    precise vec3 b = e2 * scale;
    return cross3(a, b);
}

vec3 normalised(vec3 n) {
    precise float length_n = max(sqrt(dot3(n, n)), 1e-30);
    precise vec3 unit = vec3(n.x / length_n, n.y / length_n, n.z / length_n);
    return unit;
}
